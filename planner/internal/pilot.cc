#include "planner/internal/pilot.h"

#include <algorithm>

namespace palpate {
namespace {

// Of ε: how far the tool lifts off a touch at least before it goes elsewhere.
constexpr double kLift = 0.05;
// A way over the roadmap that is longer than the straight one by that factor is not worth its length.
constexpr double kDetour = 4.0;
// Farther than that many ε, straight ways lead through S more often than not: the first hop goes over it.
constexpr double kNear = 6.0;
// After so many touches on the way to one place the tool goes round.
constexpr int kMaxContacts = 6;
// That often the tool goes out of ω and in again above the place, before it goes back over the roadmap.
constexpr int kMaxRounds = 2;
// What is in the way is passed higher every time, by this part of the way's length.
constexpr double kOver = 0.5;

std::array<double, 3> key(const Point& p) { return {p.x(), p.y(), p.z()}; }

}  // namespace

Pilot::Pilot(MaintainedDelaunay& state, Tool& tool, const Inference& inference, double epsilon, double retract)
    : state_(state),
      tool_(tool),
      inference_(inference),
      free_space_(state, inference, epsilon),
      epsilon_(epsilon),
      lift_(std::max(kLift * epsilon, retract)) {}

// --- places ----------------------------------------------------------------------------------------------------------

std::optional<std::uint32_t> Pilot::home_of(const Point& p) {
    const auto is_home = [&](std::uint32_t sample) { return inference_.has_clearance(sample) && inference_.clearance(sample).contains(p); };
    if (is_home(near_)) return near_;
    near_ = state_.nearest_sample(p, state_.cell_at(near_));
    if (is_home(near_)) return near_;
    std::vector<std::uint32_t> around;
    state_.adjacent_samples(near_, around);
    state_.sort_by_distance(p, around);
    const auto home = std::find_if(around.begin(), around.end(), is_home);
    if (home == around.end()) return std::nullopt;
    return *home;
}

std::optional<HoverPlace> Pilot::place() {
    const Point& at = state_.roadmap().at(tool_.at());
    const auto home = home_of(at);
    if (!home) return std::nullopt;
    return HoverPlace{at, *home};
}

NodeId Pilot::door(std::uint32_t sample) {
    if (doors_.size() <= sample) doors_.resize(sample + 1, kNoNode);
    if (doors_[sample] != kNoNode || !inference_.has_clearance(sample)) return doors_[sample];
    const NodeId start = tool_.start_of_sample(sample);
    const Point& apex = state_.sample(sample);
    const Vector way = state_.roadmap().at(start) - apex;
    const double length = way.norm();
    const auto inside = inference_.clearance(sample).clip(apex, way / length);
    if (!inside || inside->low >= length) return kNoNode;
    const double low = std::max(inside->low, 0.0);
    const double high = std::min(inside->high, length);
    const double at = std::clamp(epsilon_, low + (high - low) / 4, high - (high - low) / 4);
    return doors_[sample] = state_.roadmap().add(start, apex + at / length * way);
}

void Pilot::forget(std::uint32_t sample) {
    if (sample < doors_.size()) doors_[sample] = kNoNode;
}

// --- motion ----------------------------------------------------------------------------------------------------------

void Pilot::lift() {
    const auto& [contact, from] = tool_.contact();
    if (tool_.at() != contact) return;
    const Roadmap& roadmap = state_.roadmap();
    const Point touched = roadmap.at(contact);
    const Vector way = roadmap.at(from) - touched;
    const double length = way.norm();
    const bool is_short = length <= 2 * lift_;
    // From a place beside S that it hardly left the tool could not get away again.
    if (from != lifted_ || !is_short) retreat_ = from;
    const Point lifted = touched + lift_ / length * way;
    if (is_short || !home_of(lifted)) return tool_.go_to(retreat_);
    tool_.lift(lifted);
    lifted_ = tool_.at();
}

std::optional<Pilot::Met> Pilot::follow(const FreeSpace::Way& way) {
    for (const HoverPlace& stop : way.stops) {
        near_ = stop.home;
        if (const auto touched = tool_.move_to(stop.point)) return Met{*touched, true};
    }
    return std::nullopt;
}

std::optional<Pilot::Met> Pilot::probe(const Point& goal, bool expects) {
    const NodeId from = tool_.at();
    const auto expected = expects ? std::optional(Tool::Expected{goal}) : std::nullopt;
    const Tool::Answer answer = tool_.probe(goal, Touch::Role::crossing, expected);
    if (answer.failed) return Met{answer, false};
    tool_.arrive(state_.roadmap().add(from, answer.position));
    if (!answer.contact) return std::nullopt;
    return Met{answer, false};
}

std::optional<Pilot::Met> Pilot::go_to(const HoverPlace& goal) {
    lift();
    if (const auto from = place()) {
        if (const auto way = free_space_.way(*from, goal)) return follow(*way);
    }
    if (tool_.at() == lifted_) {
        // No lens leads away from beside the touch.
        tool_.go_to(retreat_);
        if (const auto from = place()) {
            if (const auto way = free_space_.way(*from, goal)) return follow(*way);
        }
    }
    // Over ground that the tool has been on, or over what is in the way.
    Roadmap& roadmap = state_.roadmap();
    const double straight = (goal.point - roadmap.at(tool_.at())).norm();
    const NodeId entry = door(goal.home);
    if (entry == kNoNode || roadmap.short_path(tool_.at(), entry).length > kDetour * straight) {
        Hop hop = this->hop(goal.point);
        if (hop.done) return hop.met;
    }
    if (entry == kNoNode) return probe(goal.point);
    tool_.go_to(entry);
    if (const auto way = free_space_.way({roadmap.at(entry), goal.home}, goal)) return follow(*way);
    return probe(goal.point);
}

Vector Pilot::up_at(const Point& p) {
    near_ = state_.nearest_sample(p, state_.cell_at(near_));
    return inference_.has_clearance(near_) ? inference_.normal(near_) : Vector((p - state_.sample(near_)).normalized());
}

Pilot::Hop Pilot::go_round(const Point& goal) {
    int& contacts = contacts_[key(goal)];
    Roadmap& roadmap = state_.roadmap();
    const Point start = roadmap.at(tool_.at());
    const Vector out = up_at(start);
    const Vector in = up_at(goal);
    const auto chord_out = state_.workspace().clip(start, out);
    const auto chord_in = state_.workspace().clip(goal, in);
    if (!chord_out || !chord_in) return {};
    std::optional<Met> met;
    if (!roadmap.on_boundary(tool_.at())) {
        met = probe(start + chord_out->high * out);
        if (!met) {
            const NodeId outside = roadmap.add_on_boundary(roadmap.at(tool_.at()));
            roadmap.connect(tool_.at(), outside);
            tool_.arrive(outside);
        }
    }
    if (!met) {
        tool_.go_to(roadmap.add_on_boundary(goal + chord_in->high * in));
        met = probe(goal);
    }
    if (met) ++contacts;
    return {true, met};
}

Pilot::Hop Pilot::hop(const Point& goal) {
    int& contacts = contacts_[key(goal)];
    if (contacts >= kMaxContacts) return contacts < kMaxContacts + kMaxRounds ? go_round(goal) : Hop{};
    const Point start = state_.roadmap().at(tool_.at());
    const double straight = (goal - start).norm();
    std::optional<Met> met;
    const int height = contacts + (straight > kNear * epsilon_ ? 1 : 0);
    if (height > 0) {
        const Vector up = up_at(start);
        const auto chord = state_.workspace().clip(start, up);
        if (chord) met = probe(start + std::min(kOver * height * straight, chord->high) * up);
    }
    if (!met) met = probe(goal);
    if (met) ++contacts;
    return {true, met};
}

std::optional<Pilot::Met> Pilot::approach(NodeId goal, const std::array<std::uint32_t, 3>& samples, bool is_cramped) {
    Roadmap& roadmap = state_.roadmap();
    lift();
    const Point goal_at = roadmap.at(goal);
    const Point from_at = roadmap.at(tool_.at());
    const double straight = (goal_at - from_at).norm();
    double shortest = roadmap.short_path(tool_.at(), goal).length;
    if (shortest <= straight) return std::nullopt;
    int& contacts = contacts_[key(goal_at)];
    if (const auto from = place(); from && contacts == 0) {
        std::optional<FreeSpace::Way> best;
        NodeId out_of_best = kNoNode;
        for (const std::uint32_t sample : samples) {
            const NodeId out = door(sample);
            if (out == kNoNode) continue;
            const auto way = free_space_.way(*from, {roadmap.at(out), sample});
            if (!way) continue;
            const double length = way->length + roadmap.short_path(out, goal).length;
            if (length >= shortest) continue;
            shortest = length;
            best = way;
            out_of_best = out;
        }
        if (best && shortest <= kDetour * straight) {
            if (const auto met = follow(*best)) {
                ++contacts;
                return met;
            }
            // The same place as the door, by another way.
            roadmap.connect(tool_.at(), out_of_best);
            tool_.arrive(out_of_best);
            return std::nullopt;
        }
    }
    if (shortest <= kDetour * straight || (is_cramped && contacts > 0)) return std::nullopt;
    const Hop hop = this->hop(goal_at);
    if (!hop.done || hop.met) return hop.met;
    roadmap.connect(tool_.at(), goal);
    tool_.arrive(goal);
    return std::nullopt;
}

}  // namespace palpate
