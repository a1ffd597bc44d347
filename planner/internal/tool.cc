#include "planner/internal/tool.h"

#include <cassert>
#include <stdexcept>

namespace palpate {
namespace {

// A start on the boundary counts as outside: fraction of ω's radius that rounding may cost.
constexpr double kOnBoundary = 1e-9;

}  // namespace

Tool::Tool(SurfaceOracle& oracle, const Workspace& workspace, Roadmap& roadmap) : oracle_(oracle), roadmap_(roadmap) {
    const Point start = oracle.position();
    const Point entry = workspace.nearest_boundary(start);
    const double distance = (entry - start).norm();
    if (workspace.contains(start) && distance > kOnBoundary * workspace.radius()) {
        throw std::invalid_argument("the tool starts inside the workspace, where no way is proven free: move it outside first");
    }
    at_ = roadmap_.add_on_boundary(entry);
    if (start != entry) {
        oracle_.travel({&entry, 1});
        account_.travel += distance;
    }
}

void Tool::go_to(NodeId node) {
    if (node == at_) return;
    const Roadmap::Path path = roadmap_.short_path(at_, node);
    if (!path.points.empty()) oracle_.travel(path.points);
    account_.travel += path.length;
    at_ = node;
}

Tool::Answer Tool::probe(const Point& target, Touch::Role role) {
    assert(at_ != kNoNode);
    const NodeId start = at_;
    const Point from = roadmap_.at(start);
    const ProbeAnswer answer = oracle_.probe(target);
    if (answer.outcome == ProbeAnswer::Outcome::failed) return failed_at(from);
    account_.probing += (answer.position - from).norm();
    at_ = kNoNode;
    if (answer.outcome == ProbeAnswer::Outcome::clear) {
        ++account_.clear;
        return {false, false, answer.position, 0};
    }
    return note_touch(start, answer.position, role);
}

Tool::Answer Tool::note_touch(NodeId start, const Point& touched, Touch::Role role) {
    ++account_.contact;
    touches_now_ = true;
    touches_.push_back({touched, roadmap_.at(start), role, std::nullopt});
    touch_starts_.push_back(start);
    return {true, false, touched, static_cast<std::uint32_t>(touches_.size() - 1)};
}

Tool::Answer Tool::failed_at(const Point& from) {
    ++account_.failed;
    return {false, true, from, 0};
}

void Tool::arrive(NodeId node) {
    if (touches_now_) contact_ = {node, touch_starts_.back()};
    touches_now_ = false;
    at_ = node;
}

void Tool::lift(const Point& to) {
    assert(at_ == contact_.at);
    oracle_.travel({&to, 1});
    account_.travel += (to - roadmap_.at(at_)).norm();
    at_ = roadmap_.add(contact_.from, to);
}

std::optional<Tool::Answer> Tool::move_to(const Point& target) {
    const NodeId start = at_;
    const ProbeAnswer answer = oracle_.probe(target);
    if (answer.outcome == ProbeAnswer::Outcome::failed) return failed_at(roadmap_.at(start));
    account_.travel += (answer.position - roadmap_.at(start)).norm();
    std::optional<Answer> touched;
    if (answer.outcome == ProbeAnswer::Outcome::contact) touched = note_touch(start, answer.position, Touch::Role::crossing);
    arrive(roadmap_.add(start, answer.position));
    return touched;
}

void Tool::assign(std::uint32_t touch, Touch::Role role, std::uint32_t sample) {
    touches_[touch].role = role;
    touches_[touch].sample = sample;
    if (sample_starts_.size() <= sample) sample_starts_.resize(sample + 1, kNoNode);
    sample_starts_[sample] = touch_starts_[touch];
}

}  // namespace palpate
