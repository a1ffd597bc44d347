#include "planner/motion/near_travel.h"

#include <algorithm>

namespace palpate {
namespace {

// Of ε: how far the tool lifts off a touch at least before it goes elsewhere.
constexpr double kLift = 0.05;
// A way over the roadmap that is longer than the straight one by that factor is not worth its length.
constexpr double kDetour = 4.0;
// Over hover points a way is by up to that factor longer than with its corners cut.
constexpr double kCorners = 1.25;
// Farther than that many ε, straight ways lead through S more often than not: the first hop goes over it.
constexpr double kNear = 6.0;
// After so many touches on the way to one place the tool goes round.
constexpr int kMaxContacts = 6;
// That often the tool goes out of ω and in again above the place, before it goes back over the roadmap_.
constexpr int kMaxRounds = 2;
// What is in the way is passed higher every time, by this part of the way's length.
constexpr double kOver = 0.5;

std::array<double, 3> key(const Point& p) { return {p.x(), p.y(), p.z()}; }

}  // namespace

NearTravel::NearTravel(ProbedSpace& space, ProbeHead& head, const SurfaceModel& model, double epsilon, double retract)
    : state_(space.delaunay()),
      roadmap_(space.roadmap()),
      head_(head),
      model_(model),
      free_space_(space.delaunay(), model, epsilon),
      epsilon_(epsilon),
      lift_(std::max(kLift * epsilon, retract)) {}

// --- places ----------------------------------------------------------------------------------------------------------

std::optional<std::uint32_t> NearTravel::home_of(const Point& p) {
    const auto is_home = [&](std::uint32_t sample) { return model_.has_clearance(sample) && model_.clearance(sample).contains(p); };
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

std::optional<HoverPlace> NearTravel::place() {
    const Point& at = roadmap_.at(head_.at());
    const auto home = home_of(at);
    if (!home) return std::nullopt;
    return HoverPlace{at, *home};
}

NodeId NearTravel::door(std::uint32_t sample) {
    if (doors_.size() <= sample) doors_.resize(sample + 1, kNoNode);
    if (!model_.has_clearance(sample)) return doors_[sample] = kNoNode;
    // Plausible space becomes smaller where a touch contradicts it.
    if (doors_[sample] != kNoNode && model_.clearance(sample).contains(roadmap_.at(doors_[sample]))) return doors_[sample];
    const NodeId start = head_.start_of_sample(sample);
    if (start == kNoNode) return kNoNode;  // on a known solid, where the tool never was
    const Point& apex = state_.sample(sample);
    const Vector way = roadmap_.at(start) - apex;
    const double length = way.norm();
    const auto inside = model_.clearance(sample).clip(apex, way / length);
    if (!inside || inside->low >= length) return kNoNode;
    const double low = std::max(inside->low, 0.0);
    const double high = std::min(inside->high, length);
    const double at = std::clamp(epsilon_, low + (high - low) / 4, high - (high - low) / 4);
    return doors_[sample] = roadmap_.add(start, apex + at / length * way);
}

// --- motion ----------------------------------------------------------------------------------------------------------

void NearTravel::lift() {
    const auto& [contact, from] = head_.contact();
    if (head_.at() != contact) return;
    const Point touched = roadmap_.at(contact);
    const Vector way = roadmap_.at(from) - touched;
    const double length = way.norm();
    const bool is_short = length <= 2 * lift_;
    // From a place beside S that it hardly left the tool could not get away again.
    if (from != lifted_ || !is_short) retreat_ = from;
    const Point lifted = touched + lift_ / length * way;
    if (is_short || !home_of(lifted)) return head_.go_to(retreat_);
    head_.lift(lifted);
    lifted_ = head_.at();
}

std::optional<NearTravel::Met> NearTravel::follow(const FreeSpace::Way& way) {
    for (const HoverPlace& stop : way.stops) {
        near_ = stop.home;
        if (const auto met = head_.move_to(stop.point)) return met;
    }
    return std::nullopt;
}

std::optional<NearTravel::Met> NearTravel::probe(const Point& goal, bool expects) {
    const auto expected = expects ? std::optional(ProbeHead::Expected{goal}) : std::nullopt;
    const ProbeHead::Answer answer = head_.probe({goal}, Touch::Role::crossing, expected);
    if (answer.is_contact() || answer.is_failed()) return answer;
    return std::nullopt;
}

std::optional<NearTravel::Met> NearTravel::go_to(const HoverPlace& goal) {
    lift();
    if (const auto from = place()) {
        if (const auto way = free_space_.way(*from, goal)) return follow(*way);
    }
    if (head_.at() == lifted_) {
        // No lens leads away from beside the touch.
        head_.go_to(retreat_);
        if (const auto from = place()) {
            if (const auto way = free_space_.way(*from, goal)) return follow(*way);
        }
    }
    // Over ground that the tool has been on, or over what is in the way.
    const double straight = (goal.point - roadmap_.at(head_.at())).norm();
    const NodeId entry = door(goal.home);
    if (entry == kNoNode || roadmap_.short_path(head_.at(), entry).length > kDetour * straight) {
        Hop hop = this->hop(goal.point);
        if (hop.done) return hop.met;
    }
    if (entry == kNoNode) return probe(goal.point);
    head_.go_to(entry);
    if (const auto way = free_space_.way({roadmap_.at(entry), goal.home}, goal)) return follow(*way);
    return probe(goal.point);
}

Vector NearTravel::up_at(const Point& p) {
    near_ = state_.nearest_sample(p, state_.cell_at(near_));
    return model_.has_clearance(near_) ? model_.normal(near_) : Vector((p - state_.sample(near_)).normalized());
}

NearTravel::Hop NearTravel::go_round(const Point& goal) {
    int& contacts = contacts_[key(goal)];
    const Point start = roadmap_.at(head_.at());
    const Vector out = up_at(start);
    const Vector in = up_at(goal);
    const auto chord_out = state_.surroundings().unknown_part(start, out);
    const auto chord_in = state_.surroundings().unknown_part(goal, in);
    if (!chord_out || !chord_in) return {};
    const Point exit = start + chord_out->high * out;
    const Point entry = goal + chord_in->high * in;
    if (!state_.surroundings().is_enterable(exit) || !state_.surroundings().is_enterable(entry)) return {};
    std::optional<Met> met;
    if (!roadmap_.on_boundary(head_.at())) {
        met = probe(exit);
        if (!met) head_.stand_at(roadmap_.add_on_boundary(roadmap_.at(head_.at())));
    }
    if (!met) {
        head_.go_to(roadmap_.add_on_boundary(entry));
        met = probe(goal);
    }
    if (met) ++contacts;
    return {true, met};
}

NearTravel::Hop NearTravel::hop(const Point& goal) {
    int& contacts = contacts_[key(goal)];
    if (contacts >= kMaxContacts) return contacts < kMaxContacts + kMaxRounds ? go_round(goal) : Hop{};
    const Point start = roadmap_.at(head_.at());
    const double straight = (goal - start).norm();
    std::optional<Met> met;
    const int height = contacts + (straight > kNear * epsilon_ ? 1 : 0);
    if (height > 0) {
        const Vector up = up_at(start);
        const auto chord = state_.surroundings().unknown_part(start, up);
        if (chord) met = probe(start + std::min(kOver * height * straight, chord->high) * up);
    }
    if (!met) met = probe(goal);
    if (met) ++contacts;
    return {true, met};
}

std::optional<NearTravel::Met> NearTravel::approach(NodeId goal, const std::array<std::uint32_t, 3>& samples, bool is_cramped) {
    lift();
    const Point goal_at = roadmap_.at(goal);
    const Point from_at = roadmap_.at(head_.at());
    const double straight = (goal_at - from_at).norm();
    double shortest = roadmap_.short_path(head_.at(), goal).length;
    if (shortest <= straight) return std::nullopt;
    int& contacts = contacts_[key(goal_at)];
    if (const auto from = place(); from && contacts == 0) {
        std::optional<FreeSpace::Way> best;
        NodeId out_of_best = kNoNode;
        for (const std::uint32_t sample : samples) {
            const NodeId out = door(sample);
            if (out == kNoNode) continue;
            const double rest = roadmap_.short_path(out, goal).length;
            const auto way = free_space_.way(*from, {roadmap_.at(out), sample}, kCorners * std::min(shortest, kDetour * straight) - rest);
            if (!way || way->length + rest >= shortest) continue;
            shortest = way->length + rest;
            best = way;
            out_of_best = out;
        }
        if (best && shortest <= kDetour * straight) {
            if (const auto met = follow(*best)) {
                ++contacts;
                return met;
            }
            // The same place as the door, by another way.
            head_.stand_at(out_of_best);
            return std::nullopt;
        }
    }
    if (shortest <= kDetour * straight || (is_cramped && contacts > 0)) return std::nullopt;
    const Hop hop = this->hop(goal_at);
    if (!hop.done || hop.met) return hop.met;
    head_.stand_at(goal);
    return std::nullopt;
}

}  // namespace palpate
