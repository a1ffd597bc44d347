#include "planner/motion/probe_head.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <stdexcept>

#include "planner/errors.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

// A start on the boundary counts as outside: fraction of ω's radius that rounding may cost.
constexpr double kOnBoundary = 1e-9;
// More false triggers than that on one move, and it has failed.
constexpr int kMaxVanished = 8;
// Touches among which the known place is looked for, the last ones: the tool is near them.
constexpr std::size_t kKnownPlaces = 64;
// ... and of those, the ways to so many are compared.
constexpr std::size_t kWaysCompared = 8;
// A straight way through what is not known to be free is worth it if the other one is that much longer.
constexpr double kWorthStraight = 2.0;
// Of the overtravel: a touch nearer than that to a doubtful place is no other place.
constexpr double kSamePlace = 0.1;

constexpr const char* kSilent =
    ", a known place: the probe does not close any more, or the part is gone. Look at its lead, plug and battery, press it by hand "
    "(palpate "
    "check), then resume: what was found free since the last contact is asked again";
constexpr const char* kUnproven =
    ": nothing shows that the probe works. Press it by hand and see it close (palpate check), then resume at a terminal, without --yes, "
    "where it "
    "can be pressed again; or begin a new session with probing.seed_rays that meet the part";

}  // namespace

ProbeHead::ProbeHead(SurfaceOracle& oracle, const Surroundings& surroundings, Roadmap& roadmap, const std::optional<ProbeWatch>& watch)
    : oracle_(oracle), surroundings_(surroundings), roadmap_(roadmap), watch_(watch), home_(oracle.position()) {
    const Point entry = surroundings.nearest_entry(home_);
    const double distance = (entry - home_).norm();
    if (!surroundings.is_free(home_) && distance > kOnBoundary * surroundings.region().radius()) {
        throw std::invalid_argument("the tool starts inside the workspace, where no way is proven free: move it outside first");
    }
    at_ = roadmap_.add_on_boundary(entry);
    if (home_ != entry) {
        oracle_.travel({&entry, 1}, watch_ ? Ground::unconfirmed : Ground::proven);
        cost_.travel += distance;
    }
}

// --- moving ----------------------------------------------------------------------------------------------------------

void ProbeHead::go_to(NodeId node) {
    if (watch_ && watch_->is_due()) show_alive({}, node);
    move_along(node, false);
}

void ProbeHead::move_along(NodeId node, bool slowly) {
    if (node == at_) return;
    const Roadmap::Path path = roadmap_.short_path(at_, node);
    follow(path.points, slowly);
    cost_.travel += path.length;
    at_ = node;
}

void ProbeHead::follow(const std::vector<Point>& points, bool slowly) {
    Point from = roadmap_.at(at_);
    const auto ground_to = [&](const Point& to) {
        return watch_ && (slowly || watch_->is_unconfirmed({from, to})) ? Ground::unconfirmed : Ground::proven;
    };
    for (auto first = points.begin(); first != points.end();) {
        const Ground ground = ground_to(*first);
        auto last = first;
        do {
            require_free_of_known({from, *last});
            from = *last++;
        } while (last != points.end() && ground_to(*last) == ground);
        oracle_.travel({first, last}, ground);
        first = last;
    }
}

void ProbeHead::go_back(const Point& from) {
    const Point start = roadmap_.at(at_);
    if (from == start) return;
    oracle_.travel({&start, 1}, Ground::unconfirmed);
    cost_.travel += (start - from).norm();
}

void ProbeHead::stand_at(NodeId node) {
    roadmap_.connect(at_, node);
    at_ = node;
}

void ProbeHead::lift(const Point& to) {
    assert(at_ == contact_.at);
    oracle_.travel({&to, 1}, Ground::proven);
    cost_.travel += (to - roadmap_.at(at_)).norm();
    at_ = roadmap_.add(contact_.from, to);
}

// --- asking ----------------------------------------------------------------------------------------------------------

void ProbeHead::require_free_of_known(const Segment& move) const {
    if (surroundings_.first_known(move)) {
        throw std::logic_error("ProbeHead: a move from " + point_text(move.source) + " to " + point_text(move.target) +
                               " leads into a known solid");
    }
}

ProbeAnswer ProbeHead::ask(const Point& target, double& way) {
    const Point from = roadmap_.at(at_);
    require_free_of_known({from, target});
    ProbeAnswer answer = oracle_.probe(target);
    for (int again = 0; answer.outcome == ProbeAnswer::Outcome::vanished && again < kMaxVanished; ++again) {
        if (watch_ && watch_->has_contact()) show_alive({Doubt::vanished, target}, at_);
        answer = oracle_.probe(target);
    }
    // Sparks that never agree are no contact, and show nothing.
    if (answer.outcome == ProbeAnswer::Outcome::vanished) answer.outcome = ProbeAnswer::Outcome::failed;
    if (watch_ && answer.outcome == ProbeAnswer::Outcome::clear) watch_->note_clear({from, answer.position});
    if (watch_ && answer.outcome == ProbeAnswer::Outcome::contact) watch_->note_contact();
    way += (answer.position - from).norm();
    return answer;
}

ProbeAnswer ProbeHead::ask_expecting(const Point& target, const Expected& expected) {
    const Point from = roadmap_.at(at_);
    // No deeper than the probe gives way beyond what is expected.
    const Point deepest = expected.before + watch_->overtravel() * (target - from).normalized();
    const Point goal = (deepest - from).squaredNorm() < (target - from).squaredNorm() ? deepest : target;
    for (const bool again : {false, true}) {
        ProbeAnswer answer = ask(goal, cost_.probing);
        if (answer.outcome != ProbeAnswer::Outcome::clear) {
            if (again) watch_->note_recovery();
            return answer;
        }
        ++cost_.clear;
        ++cost_.checks;
        go_back(answer.position);
    }
    show_alive({Doubt::missed, expected.before}, at_);
    ProbeAnswer answer = ask(target, cost_.probing);
    if (answer.outcome == ProbeAnswer::Outcome::contact) watch_->note_recovery();
    return answer;  // a clear is a finding now
}

ProbeHead::Answer ProbeHead::probe(const Destination& destination, Touch::Role role, const std::optional<Expected>& expected) {
    if (watch_ && watch_->is_due()) show_alive({}, at_);
    const auto known = surroundings_.first_known({roadmap_.at(at_), destination.position});
    if (known && !known->is_solid) return failed();
    const Point& target = known ? known->at : destination.position;
    const bool expects = watch_ && expected && !known;  // what is known is not touched
    ProbeAnswer answer = expects ? ask_expecting(target, *expected) : ask(target, cost_.probing);
    if (answer.outcome == ProbeAnswer::Outcome::clear && watch_ && !expects && watch_->misses_touches()) {
        ++cost_.clear;
        ++cost_.checks;
        go_back(answer.position);
        answer = ask(target, cost_.probing);
    }
    if (answer.outcome == ProbeAnswer::Outcome::failed) return failed();
    if (answer.outcome == ProbeAnswer::Outcome::contact) return note_touch(answer.position, role);
    ++cost_.clear;
    if (known) return note_touch(known->at, role, true);
    at_ = roadmap_.add(at_, {answer.position, destination.node, destination.on_boundary});
    return {answer.outcome, answer.position};
}

std::optional<ProbeHead::Answer> ProbeHead::move_to(const Point& target) {
    if (watch_ && watch_->is_due()) show_alive({}, at_);
    const auto known = surroundings_.first_known({roadmap_.at(at_), target});
    if (known && !known->is_solid) return failed();
    const ProbeAnswer answer = ask(known ? known->at : target, cost_.travel);
    if (answer.outcome == ProbeAnswer::Outcome::failed) return failed();
    if (answer.outcome == ProbeAnswer::Outcome::contact || known) {
        Answer touched = note_touch(answer.position, Touch::Role::crossing, answer.outcome != ProbeAnswer::Outcome::contact);
        touched.on_free_way = true;
        return touched;
    }
    at_ = roadmap_.add(at_, answer.position);
    return std::nullopt;
}

ProbeHead::Answer ProbeHead::note_touch(const Point& touched, Touch::Role role, bool is_known) {
    ++(is_known ? cost_.known_contact : cost_.contact);
    touches_.push_back({touched, roadmap_.at(at_), role, std::nullopt, is_known});
    touch_starts_.push_back(at_);
    if (!is_known) last_touched_ = {at_, touched};
    contact_ = {roadmap_.add(at_, touched), at_};
    at_ = contact_.at;
    return {ProbeAnswer::Outcome::contact, touched, static_cast<std::uint32_t>(touches_.size() - 1), false, is_known};
}

std::uint32_t ProbeHead::note_known(const Point& at, const Point& from) {
    ++cost_.known_contact;
    touches_.push_back({at, from, Touch::Role::crossing, std::nullopt, true});
    touch_starts_.push_back(kNoNode);
    return static_cast<std::uint32_t>(touches_.size() - 1);
}

std::uint32_t ProbeHead::note_earlier(const Point& at, const Point& from) {
    touches_.push_back({at, from, Touch::Role::earlier, std::nullopt});
    touch_starts_.push_back(kNoNode);
    return static_cast<std::uint32_t>(touches_.size() - 1);
}

ProbeHead::Answer ProbeHead::failed() {
    ++cost_.failed;
    return {ProbeAnswer::Outcome::failed, roadmap_.at(at_)};
}

// --- whether the probe still works -----------------------------------------------------------------------------------

void ProbeHead::show_alive(const Doubt& doubt, NodeId next) {
    std::vector<Point> passed_over;
    if (doubt.kind == Doubt::missed) passed_over.push_back(doubt.place);
    const std::optional<KnownPlace> place = nearest_known(passed_over, next);
    if (!place) {
        if (oracle_.prove_alive()) return watch_->note_proof();
        throw SilenceError(text(doubt) + kUnproven);
    }
    const bool is_shown =
        doubt.kind == Doubt::many_clears ? touch_some(*place, passed_over) : visit(*place, true, watch_->misses_touches());
    if (!is_shown) {
        throw SilenceError(fmt::format("{}; then nothing was touched at {}{}", text(doubt), point_text(place->position), kSilent));
    }
    if (next != kNoNode) move_along(next, false);  // what is behind is confirmed now
}

// Where nothing was expected, the known place itself is what is expected: it is asked again, and then another one.
bool ProbeHead::touch_some(const KnownPlace& place, std::vector<Point>& passed_over) {
    // What is met on a straight way there shows as much.
    if (place.straight && !hop_to(place.from)) return true;
    if (visit(place, false, true)) return true;
    passed_over.push_back(place.position);
    const std::optional<KnownPlace> other = nearest_known(passed_over, at_);
    return other && visit(*other, true, watch_->misses_touches());
}

bool ProbeHead::visit(const KnownPlace& place, bool slowly, bool twice) {
    move_along(place.from, slowly);
    if (touch_again(place)) return true;
    if (!twice || !touch_again(place)) return false;
    watch_->note_recovery();
    return true;
}

bool ProbeHead::hop_to(NodeId node) {
    const NodeId start = at_;
    const ProbeAnswer answer = ask(roadmap_.at(node), cost_.travel);
    if (answer.outcome == ProbeAnswer::Outcome::clear) {
        stand_at(node);  // the way there is one more
        return true;
    }
    note_check(answer, start);
    go_back(answer.position);
    return false;
}

void ProbeHead::note_check(const ProbeAnswer& answer, NodeId from) {
    ++cost_.checks;
    if (answer.outcome == ProbeAnswer::Outcome::clear) ++cost_.clear;
    if (answer.outcome != ProbeAnswer::Outcome::contact) return;
    ++cost_.contact;
    touches_.push_back({answer.position, roadmap_.at(from), Touch::Role::check, std::nullopt});
    touch_starts_.push_back(from);
}

std::string ProbeHead::text(const Doubt& doubt) {
    switch (doubt.kind) {
        case Doubt::missed:
            return fmt::format("a contact was expected at {} at the latest and stayed away twice", point_text(doubt.place));
        case Doubt::vanished:
            return fmt::format("on the way to {} something was touched and, twice, not again", point_text(doubt.place));
        case Doubt::many_clears:
            break;
    }
    return watch_->has_contact() ? "many moves met nothing" : "nothing was touched so far";
}

std::optional<ProbeHead::KnownPlace> ProbeHead::nearest_known(const std::vector<Point>& passed_over, NodeId next) {
    struct Candidate {
        double distance;  // mm, straight
        std::size_t touch;
    };
    std::vector<Candidate> candidates;
    std::size_t seen = 0;
    for (std::size_t k = touches_.size(); k-- > 0 && seen < kKnownPlaces;) {
        const Touch& touch = touches_[k];
        const bool is_ours = touch.role != Touch::Role::check && touch.role != Touch::Role::earlier && !touch.is_known;
        if (!is_ours || touch.from == touch.position) continue;
        ++seen;
        const auto is_same = [&](const Point& p) { return (p - touch.position).norm() < kSamePlace * watch_->overtravel(); };
        if (std::ranges::any_of(passed_over, is_same)) continue;
        const double onwards = next != kNoNode ? (touch.from - roadmap_.at(next)).norm() : 0.0;
        candidates.push_back({(touch.from - roadmap_.at(at_)).norm() + 2 * (touch.from - touch.position).norm() + onwards, k});
    }
    std::ranges::stable_sort(candidates, {}, &Candidate::distance);
    // The way back to the last touch is short where the roadmap is a thread.
    if (candidates.size() > kWaysCompared) {
        const auto last = std::ranges::max_element(candidates, {}, &Candidate::touch);
        std::iter_swap(candidates.begin() + kWaysCompared - 1, last);
        candidates.resize(kWaysCompared);
    }
    std::optional<KnownPlace> nearest;
    double least = 0;
    for (const Candidate& candidate : candidates) {
        KnownPlace place{touch_starts_[candidate.touch], touches_[candidate.touch].position};
        double way = roadmap_.short_path(at_, place.from).length;
        const double straight = (roadmap_.at(place.from) - roadmap_.at(at_)).norm();
        place.straight = straight <= watch_->longest_hop() && way > kWorthStraight * straight &&
                         !surroundings_.first_known({roadmap_.at(at_), roadmap_.at(place.from)});
        if (place.straight) way = straight;
        way += 2 * (place.position - roadmap_.at(place.from)).norm();
        if (next != kNoNode) way += roadmap_.short_path(place.from, next).length;
        if (nearest && way >= least) continue;
        nearest = place;
        least = way;
    }
    return nearest;
}

bool ProbeHead::touch_again(const KnownPlace& place) {
    const Point from = roadmap_.at(place.from);
    const Vector direction = (place.position - from).normalized();
    Point target = place.position + watch_->overtravel() * direction;
    // What is outside ω may be outside the machine's limits.
    if (const auto chord = surroundings_.unknown_part(from, direction))
        target = from + std::min((target - from).norm(), chord->high) * direction;
    if (const auto known = surroundings_.first_known({from, target})) target = known->at;
    ProbeAnswer answer = oracle_.probe(target);
    // What vanishes is no contact, and no sign of a dead probe either: it triggered.
    for (int again = 0; answer.outcome == ProbeAnswer::Outcome::vanished && again < kMaxVanished; ++again) answer = oracle_.probe(target);
    note_check(answer, place.from);
    cost_.probing += (answer.position - from).norm();
    const bool is_shown = answer.outcome == ProbeAnswer::Outcome::contact;
    if (is_shown) {
        watch_->note_contact();
        last_touched_ = place;
    }
    go_back(answer.position);
    return is_shown;
}

void ProbeHead::end_of_run() {
    if (watch_ && watch_->is_in_doubt()) show_alive({}, kNoNode);
}

// --- going home ------------------------------------------------------------------------------------------------------

void ProbeHead::go_home(const std::function<void(double)>& say) {
    const Point at = roadmap_.at(at_);
    const Point gate = surroundings_.nearest_entry(home_);
    double& way = cost_.home;
    if (!roadmap_.on_boundary(at_) && last_touched_) {
        // A contact is a dead end: the way back from it is the one to where the probe began.
        const Roadmap::Path back = roadmap_.short_path(at_, last_touched_->from);
        const Point from = roadmap_.at(last_touched_->from);
        const Vector up = (from - last_touched_->position).normalized();
        const auto chord = surroundings_.unknown_part(from, up);
        const double out = chord ? std::max(chord->high, 0.0) : 0.0;
        const Point exit = from + out * up;
        if (say) say(back.length + out + surroundings_.distance(surroundings_.nearest_entry(exit), gate) + (home_ - gate).norm());
        follow(back.points, false);
        way += back.length;
        at_ = last_touched_->from;
        const Vector nearest = surroundings_.nearest_entry(from) - from;
        bool is_out = roadmap_.on_boundary(at_) || leave_along(up, way);
        if (!is_out && !nearest.isZero()) is_out = leave_along(nearest.normalized(), way);
        if (!is_out) (void)leave_along(Vector::UnitZ(), way);
    } else if (say) {
        say((at - gate).norm() + (home_ - gate).norm());
    }
    // Where something is in the way of all of these: over ground that is known to be free.
    const Roadmap::Path around = roadmap_.short_path(at_, roadmap_.add_on_boundary(gate));
    follow(around.points, false);
    way += around.length;
    if (gate != home_) oracle_.travel({&home_, 1}, watch_ && !watch_->has_contact() ? Ground::unconfirmed : Ground::proven);
    way += (home_ - gate).norm();
}

bool ProbeHead::leave_along(const Vector& direction, double& way) {
    const NodeId from = at_;
    const auto chord = surroundings_.unknown_part(roadmap_.at(from), direction);
    if (!chord) return false;
    const Point exit = roadmap_.at(from) + chord->high * direction;
    if (!surroundings_.is_enterable(exit) || surroundings_.first_known({roadmap_.at(from), exit})) return false;
    const ProbeAnswer answer = ask(exit, way);
    if (answer.outcome == ProbeAnswer::Outcome::clear) {
        at_ = roadmap_.add(from, {answer.position, kNoNode, true});
        return true;
    }
    note_check(answer, from);
    if (answer.outcome == ProbeAnswer::Outcome::contact) {
        const Point back = roadmap_.at(from);
        oracle_.travel({&back, 1}, Ground::proven);
        way += (back - answer.position).norm();
    }
    return false;
}

void ProbeHead::assign(std::uint32_t touch, Touch::Role role, std::uint32_t sample) {
    touches_[touch].role = role;
    touches_[touch].sample = sample;
    if (sample_starts_.size() <= sample) sample_starts_.resize(sample + 1, kNoNode);
    sample_starts_[sample] = touch_starts_[touch];
}

}  // namespace palpate
