#include "planner/internal/growth.h"

#include <algorithm>
#include <array>

namespace palpate {
namespace {

// Touches may be wrong by that part of ω's radius: far above the rounding of dual edges.
constexpr double kMargin = 1e-9;
// Samples within that many ε help to know each other's normals: the ring of neighbours and a little more.
constexpr double kRange = 4.0;
// Of ε: how far the tool lifts off a touch before it goes elsewhere.
constexpr double kLift = 0.05;
// A bound that was refuted is lowered to what the evidence allows, but at least by this, so that there are few rounds.
constexpr double kLowered = 0.8;
// Below that many ε, lenses are too flat to reach from one sample to the next.
constexpr double kUseful = 2.0;

bool grows(const Strategy& strategy) {
    return strategy.refine == Strategy::Refine::eager && strategy.explore == Strategy::Explore::closure &&
           strategy.travel == Strategy::Travel::free_space;
}

}  // namespace

Growth::Growth(MaintainedDelaunay& state, Tool& tool, const Workspace& workspace, const Options& options, const Criteria& criteria,
               const Observer& observer)
    : state_(state),
      tool_(tool),
      options_(options),
      criteria_(criteria),
      inference_(state, *options.reach, kRange * options.epsilon, kMargin * workspace.radius()),
      front_(state, inference_,
             {options.epsilon, options.standoff.value_or(options.epsilon), Front::kGrowth, options.audit, options.random_seed}),
      free_space_(state, inference_, options.epsilon),
      grows_(grows(options.strategy)) {
    inference_.watch(observer.on_inference);
    for (const Touch& touch : tool.touches()) {
        if (!touch.sample) continue;
        inference_.note_sample(*touch.sample, touch.from - touch.position);
    }
    front_.sweep();
}

bool Growth::infer(DirectedEdge e) {
    const auto inwards = inference_.infer(e, options_.epsilon);
    if (inwards) front_.note_edges(*inwards);
    return inwards.has_value();
}

void Growth::note_insertion(const MaintainedDelaunay::Insertion& insertion, const Touch& touch) {
    inference_.note_sample(insertion.sample, touch.from - touch.position);
    front_.note_insertion(insertion);
    if (at_ != kNoNode && at_ == tool_.at()) home_ = insertion.sample;
}

void Growth::withdraw(DirectedEdge e, const Point& free) {
    const auto corners = state_.facet_samples(e);
    inference_.check(free, false, corners);
    distrust(e);
}

void Growth::distrust(DirectedEdge e) {
    inference_.distrust(e);
    front_.note_edges(e);
}

// --- motion ----------------------------------------------------------------------------------------------------------

std::optional<HoverPlace> Growth::place() const {
    if (at_ == kNoNode || at_ != tool_.at() || home_ == kNone) return std::nullopt;
    return HoverPlace{state_.roadmap().at(at_), home_};
}

void Growth::lift() {
    if (at_ == kNoNode || at_ != tool_.at() || last_contact_ != at_) return;
    Roadmap& roadmap = state_.roadmap();
    const Point touched = roadmap.at(at_);
    const Vector way = roadmap.at(last_start_.node) - touched;
    const Point lifted = touched + std::min(kLift * options_.epsilon / way.norm(), 0.5) * way;
    std::uint32_t home = kNone;
    for (const std::uint32_t sample : {home_, last_start_.home}) {
        if (home == kNone && sample != kNone && inference_.knows(sample) && inference_.lens(sample, Side::exterior).contains(lifted)) {
            home = sample;
        }
    }
    if (home == kNone) {
        tool_.go_to(last_start_.node);
        home_ = last_start_.home;
    } else {
        const NodeId node = roadmap.add(last_start_.node, lifted);
        roadmap.connect(at_, node);
        tool_.go_to(node);
        home_ = home;
    }
    at_ = tool_.at();
}

bool Growth::follow(const FreeSpace::Way& way) {
    const auto contact = tool_.move_through(way.points);
    if (!contact) return true;
    at_ = kNoNode;
    inference_.check_way(contact->position, way.lenses);
    return false;
}

Growth::Door Growth::door(std::uint32_t sample) {
    if (doors_.size() <= sample) doors_.resize(sample + 1);
    Door& door = doors_[sample];
    if (door.node != kNoNode || !inference_.knows(sample)) return door;
    const NodeId start = tool_.start_of_sample(sample);
    const Point& apex = state_.sample(sample);
    const Vector way = state_.roadmap().at(start) - apex;
    const double length = way.norm();
    const auto inside = inference_.lens(sample, Side::exterior).clip(apex, way / length);
    if (!inside || inside->low >= length) return door;
    const double low = std::max(inside->low, 0.0);
    const double high = std::min(inside->high, length);
    const double at = std::clamp(options_.epsilon, low + (high - low) / 4, high - (high - low) / 4);
    door = {state_.roadmap().add(start, apex + at / length * way), sample};
    return door;
}

bool Growth::go_to(const Point& start, std::uint32_t home) {
    const HoverPlace goal{start, home};
    lift();
    const auto from = place();
    auto way = from ? free_space_.way(*from, goal) : std::nullopt;
    if (!way && last_start_.node != kNoNode) {
        // Back where the last probe came from: its touch may lie in no lens.
        tool_.go_to(last_start_.node);
        if (last_start_.home != kNone) way = free_space_.way({state_.roadmap().at(last_start_.node), last_start_.home}, goal);
    }
    if (!way) {
        // Over ground that the tool has been on.
        const Door entry = door(home);
        if (entry.node == kNoNode) return false;
        tool_.go_to(entry.node);
        way = free_space_.way({state_.roadmap().at(entry.node), entry.home}, goal);
        if (!way) return false;
    }
    if (!follow(*way)) return false;
    at_ = tool_.at();
    home_ = home;
    return true;
}

void Growth::approach(NodeId goal, const std::array<std::uint32_t, 3>& corners) {
    lift();
    const auto from = place();
    if (!from) return;
    Roadmap& roadmap = state_.roadmap();
    double shortest = roadmap.short_path(tool_.at(), goal).length;
    std::optional<FreeSpace::Way> best;
    NodeId best_out = kNoNode;
    for (const std::uint32_t corner : corners) {
        const Door out = door(corner);
        if (out.node == kNoNode) continue;
        const auto way = free_space_.way(*from, {roadmap.at(out.node), out.home});
        if (!way) continue;
        const double length = path_length(from->point, way->points) + roadmap.short_path(out.node, goal).length;
        if (length >= shortest) continue;
        shortest = length;
        best = way;
        best_out = out.node;
    }
    if (!best || !follow(*best)) return;
    // The same place as the door's node, by another way.
    roadmap.connect(tool_.at(), best_out);
    tool_.arrive(best_out);
}

// --- touching --------------------------------------------------------------------------------------------------------

std::optional<Growth::Step> Growth::step() {
    if (!grows_ || inference_.reach() < kUseful * options_.epsilon) return std::nullopt;
    const auto asked = front_.next(state_.roadmap().at(tool_.at()));
    if (!asked) return std::nullopt;
    if (!go_to(asked->start, asked->home)) return Step{};
    Roadmap& roadmap = state_.roadmap();
    const NodeId start = tool_.at();
    last_start_ = {start, asked->home};
    const Tool::Answer answer = tool_.probe(asked->target);
    const NodeId end = roadmap.add(start, answer.position);
    tool_.arrive(end);
    at_ = end;
    home_ = asked->home;
    last_contact_ = answer.contact ? end : kNoNode;
    if (asked->audit) ++evidence_.audited;
    if (!answer.contact) {
        if (asked->certain) {
            const std::array<std::uint32_t, 1> lens{asked->interior_of};
            inference_.check(answer.position, false, lens);
        }
        if (asked->along) {
            if (const auto inferred = state_.inferred(asked->along->inwards)) withdraw(*inferred, answer.position);
        }
        return Step{};
    }
    const std::array<std::uint32_t, 5> lenses{asked->home, asked->interior_of, asked->beside[0], asked->beside[1], asked->beside[2]};
    inference_.check(answer.position, true, lenses);
    if (inference_.refutation()) return Step{};
    const CellId near = state_.cell_at(asked->beside[0]);
    const double distance = (state_.sample(state_.nearest_sample(answer.position, near)) - answer.position).norm();
    if (criteria_.is_bad(distance)) {
        doors_.resize(std::max<std::size_t>(doors_.size(), state_.sample_count() + 1));
        doors_[state_.sample_count()] = {start, asked->home};
        return Step{NewSample{answer.position, near, answer.touch}};
    }
    learn(*asked, start, end, answer.touch);
    return Step{};
}

// A touch too near to a sample to be one.
void Growth::learn(const FrontTouch& asked, NodeId start, NodeId contact, std::uint32_t touch) {
    Roadmap& roadmap = state_.roadmap();
    const Point position = roadmap.at(contact);
    const Vector outwards = roadmap.at(start) - position;
    if (asked.along) {
        const DirectedEdge e = asked.along->inwards;
        const double height = asked.along->up.dot(position - asked.along->line.origin);
        if (height >= asked.along->bottom && height <= asked.along->top) {
            if (const auto inferred = state_.inferred(e)) state_.withdraw(*inferred);
            if (state_.recorded_state(e) == EdgeState::unknown) {
                // A probe from beyond the edge's exterior end passed it.
                const bool beyond = asked.along->up.dot(roadmap.at(start) - asked.along->line.origin) > asked.along->top;
                const NodeId from = beyond ? roadmap.split(start, contact, asked.along->at(asked.along->top)) : start;
                state_.learn_contact(e, from, contact, touch, false);
                front_.note_edges(e);
            }
        }
    }
    inference_.note_touch(position, outwards, asked.beside);
}

// --- refutation ------------------------------------------------------------------------------------------------------

bool Growth::settle_refutation() {
    if (!inference_.refutation()) return false;
    const Refutation found = *inference_.refutation();
    if (!evidence_.refuted || found.largest_reach < evidence_.largest) {
        evidence_.refuted = true;
        evidence_.largest = std::min(evidence_.largest, found.largest_reach);
        evidence_.detail = found.evidence;
    }
    for (CellId cell = 0; cell < state_.cell_slots(); ++cell) {
        if (!state_.is_live(cell)) continue;
        for (int i = 0; i < 4; ++i) {
            const DirectedEdge e{cell, i};
            if (state_.recorded_state(e) == EdgeState::crossing && state_.crossing(e).inferred) state_.withdraw(e);
        }
    }
    doors_.clear();
    inference_.lower(std::min(found.largest_reach, kLowered * inference_.reach()));
    at_ = kNoNode;
    front_.sweep();
    return true;
}

ReachEvidence Growth::evidence() const {
    ReachEvidence evidence = evidence_;
    evidence.used = inference_.reach();
    evidence.inferred = inference_.inferred();
    return evidence;
}

}  // namespace palpate
