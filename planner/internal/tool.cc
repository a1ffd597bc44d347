#include "planner/internal/tool.h"

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
constexpr double kDetour = 2.0;
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

Tool::Tool(SurfaceOracle& oracle, const Workspace& workspace, Roadmap& roadmap, const std::optional<ProbeWatch>& watch)
    : oracle_(oracle), workspace_(workspace), roadmap_(roadmap), watch_(watch), home_(oracle.position()) {
    const Point entry = workspace.nearest_boundary(home_);
    const double distance = (entry - home_).norm();
    if (workspace.contains(home_) && distance > kOnBoundary * workspace.radius()) {
        throw std::invalid_argument("the tool starts inside the workspace, where no way is proven free: move it outside first");
    }
    at_ = roadmap_.add_on_boundary(entry);
    if (home_ != entry) {
        oracle_.travel({&entry, 1}, watch_ ? Ground::unconfirmed : Ground::proven);
        account_.travel += distance;
    }
}

// --- moving ----------------------------------------------------------------------------------------------------------

void Tool::go_to(NodeId node) {
    if (watch_ && watch_->is_due()) show_alive({}, node);
    move_along(node, false);
}

void Tool::move_along(NodeId node, bool slowly) {
    if (node == at_) return;
    const Roadmap::Path path = roadmap_.short_path(at_, node);
    follow(path.points, slowly);
    account_.travel += path.length;
    at_ = node;
}

void Tool::follow(const std::vector<Point>& points, bool slowly) {
    Point from = roadmap_.at(at_);
    const auto ground_to = [&](const Point& to) {
        return watch_ && (slowly || watch_->is_unconfirmed({from, to})) ? Ground::unconfirmed : Ground::proven;
    };
    for (auto first = points.begin(); first != points.end();) {
        const Ground ground = ground_to(*first);
        auto last = first;
        do {
            from = *last++;
        } while (last != points.end() && ground_to(*last) == ground);
        oracle_.travel({first, last}, ground);
        first = last;
    }
}

void Tool::go_back(const Point& from) {
    const Point start = roadmap_.at(at_);
    if (from == start) return;
    oracle_.travel({&start, 1}, Ground::unconfirmed);
    account_.travel += (start - from).norm();
}

void Tool::arrive(NodeId node) {
    if (touches_now_) contact_ = {node, touch_starts_.back()};
    touches_now_ = false;
    at_ = node;
}

void Tool::lift(const Point& to) {
    assert(at_ == contact_.at);
    oracle_.travel({&to, 1}, Ground::proven);
    account_.travel += (to - roadmap_.at(at_)).norm();
    at_ = roadmap_.add(contact_.from, to);
}

// --- asking ----------------------------------------------------------------------------------------------------------

ProbeAnswer Tool::ask(const Point& target, double& way) {
    const Point from = roadmap_.at(at_);
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

ProbeAnswer Tool::ask_expecting(const Point& target, const Expected& expected) {
    const Point from = roadmap_.at(at_);
    // No deeper than the probe gives way beyond what is expected.
    const Point deepest = expected.before + watch_->overtravel() * (target - from).normalized();
    const Point goal = (deepest - from).squaredNorm() < (target - from).squaredNorm() ? deepest : target;
    for (const bool again : {false, true}) {
        const ProbeAnswer answer = ask(goal, account_.probing);
        if (answer.outcome != ProbeAnswer::Outcome::clear) {
            if (again) watch_->note_recovery();
            return answer;
        }
        ++account_.clear;
        ++account_.checks;
        go_back(answer.position);
    }
    show_alive({Doubt::missed, expected.before}, at_);
    const ProbeAnswer answer = ask(target, account_.probing);
    if (answer.outcome == ProbeAnswer::Outcome::contact) watch_->note_recovery();
    return answer;  // a clear is a finding now
}

Tool::Answer Tool::probe(const Point& target, Touch::Role role, const std::optional<Expected>& expected) {
    assert(at_ != kNoNode);
    if (watch_ && watch_->is_due()) show_alive({}, at_);
    const NodeId start = at_;
    ProbeAnswer answer = watch_ && expected ? ask_expecting(target, *expected) : ask(target, account_.probing);
    if (answer.outcome == ProbeAnswer::Outcome::clear && watch_ && !expected && watch_->misses_touches()) {
        ++account_.clear;
        ++account_.checks;
        go_back(answer.position);
        answer = ask(target, account_.probing);
    }
    if (answer.outcome == ProbeAnswer::Outcome::failed) return failed();
    at_ = kNoNode;
    if (answer.outcome == ProbeAnswer::Outcome::contact) return note_touch(start, answer.position, role);
    ++account_.clear;
    return {false, false, answer.position, 0};
}

std::optional<Tool::Answer> Tool::move_to(const Point& target) {
    if (watch_ && watch_->is_due()) show_alive({}, at_);
    const NodeId start = at_;
    const ProbeAnswer answer = ask(target, account_.travel);
    if (answer.outcome == ProbeAnswer::Outcome::failed) return failed();
    std::optional<Answer> touched;
    if (answer.outcome == ProbeAnswer::Outcome::contact) touched = note_touch(start, answer.position, Touch::Role::crossing);
    arrive(roadmap_.add(start, answer.position));
    return touched;
}

Tool::Answer Tool::note_touch(NodeId start, const Point& touched, Touch::Role role) {
    ++account_.contact;
    touches_now_ = true;
    touches_.push_back({touched, roadmap_.at(start), role, std::nullopt});
    touch_starts_.push_back(start);
    last_touched_ = {start, touched};
    return {true, false, touched, static_cast<std::uint32_t>(touches_.size() - 1)};
}

Tool::Answer Tool::failed() {
    ++account_.failed;
    return {false, true, roadmap_.at(at_), 0};
}

// --- whether the probe still works -----------------------------------------------------------------------------------

void Tool::show_alive(const Doubt& doubt, NodeId next) {
    std::vector<Point> passed_over;
    if (doubt.kind == Doubt::missed) passed_over.push_back(doubt.place);
    const std::optional<KnownPlace> place = nearest_known(passed_over, next);
    if (!place) {
        if (oracle_.prove_alive()) return watch_->note_proof();
        throw SilenceError(text(doubt) + kUnproven);
    }
    const bool is_shown =
        doubt.kind == Doubt::many_clears ? touch_some(*place, passed_over) : visit(*place, true, watch_->misses_touches());
    if (!is_shown) throw SilenceError(text(doubt) + "; then nothing was touched at " + point_text(place->position) + kSilent);
    if (next != kNoNode) move_along(next, false);  // what is behind is confirmed now
}

// Where nothing was expected, the known place itself is what is expected: it is asked again, and then another one.
bool Tool::touch_some(const KnownPlace& place, std::vector<Point>& passed_over) {
    // What is met on a straight way there shows as much.
    if (place.straight && !hop_to(place.from)) return true;
    if (visit(place, false, true)) return true;
    passed_over.push_back(place.position);
    const std::optional<KnownPlace> other = nearest_known(passed_over, at_);
    return other && visit(*other, true, watch_->misses_touches());
}

bool Tool::visit(const KnownPlace& place, bool slowly, bool twice) {
    move_along(place.from, slowly);
    if (touch_again(place)) return true;
    if (!twice || !touch_again(place)) return false;
    watch_->note_recovery();
    return true;
}

bool Tool::hop_to(NodeId node) {
    const NodeId start = at_;
    const ProbeAnswer answer = ask(roadmap_.at(node), account_.travel);
    if (answer.outcome == ProbeAnswer::Outcome::clear) {
        roadmap_.connect(start, node);
        at_ = node;
        return true;
    }
    note_check(answer, start);
    go_back(answer.position);
    return false;
}

void Tool::note_check(const ProbeAnswer& answer, NodeId from) {
    ++account_.checks;
    if (answer.outcome == ProbeAnswer::Outcome::clear) ++account_.clear;
    if (answer.outcome != ProbeAnswer::Outcome::contact) return;
    ++account_.contact;
    touches_.push_back({answer.position, roadmap_.at(from), Touch::Role::check, std::nullopt});
    touch_starts_.push_back(from);
}

std::string Tool::text(const Doubt& doubt) {
    switch (doubt.kind) {
        case Doubt::missed:
            return "a contact was expected at " + point_text(doubt.place) + " at the latest and stayed away twice";
        case Doubt::vanished:
            return "on the way to " + point_text(doubt.place) + " something was touched and, twice, not again";
        case Doubt::many_clears:
            break;
    }
    return watch_->has_contact() ? "many moves met nothing" : "nothing was touched so far";
}

std::optional<Tool::KnownPlace> Tool::nearest_known(const std::vector<Point>& passed_over, NodeId next) {
    struct Candidate {
        double distance;  // mm, straight
        std::size_t touch;
    };
    std::vector<Candidate> candidates;
    std::size_t seen = 0;
    for (std::size_t k = touches_.size(); k-- > 0 && seen < kKnownPlaces;) {
        const Touch& touch = touches_[k];
        if (touch.role == Touch::Role::check || touch.from == touch.position) continue;
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
        place.straight = straight <= watch_->longest_hop() && way > kDetour * straight;
        if (place.straight) way = straight;
        way += 2 * (place.position - roadmap_.at(place.from)).norm();
        if (next != kNoNode) way += roadmap_.short_path(place.from, next).length;
        if (nearest && way >= least) continue;
        nearest = place;
        least = way;
    }
    return nearest;
}

bool Tool::touch_again(const KnownPlace& place) {
    const Point from = roadmap_.at(place.from);
    const Vector direction = (place.position - from).normalized();
    Point target = place.position + watch_->overtravel() * direction;
    // What is outside ω may be outside the machine's limits.
    if (const auto chord = workspace_.clip(from, direction)) target = from + std::min((target - from).norm(), chord->high) * direction;
    const ProbeAnswer answer = oracle_.probe(target);
    note_check(answer, place.from);
    account_.probing += (answer.position - from).norm();
    const bool is_shown = answer.outcome == ProbeAnswer::Outcome::contact;
    if (is_shown) {
        watch_->note_contact();
        last_touched_ = place;
    }
    go_back(answer.position);
    return is_shown;
}

void Tool::end_of_run() {
    if (watch_ && watch_->is_in_doubt()) show_alive({}, kNoNode);
}

// --- going home ------------------------------------------------------------------------------------------------------

void Tool::go_home(const std::function<void(double)>& say) {
    const Point at = roadmap_.at(at_);
    const Point gate = workspace_.nearest_boundary(home_);
    double& way = account_.home;
    if (!roadmap_.on_boundary(at_) && last_touched_) {
        // A contact is a dead end: the way back from it is the one to where the probe began.
        const Roadmap::Path back = roadmap_.short_path(at_, last_touched_->from);
        const Point from = roadmap_.at(last_touched_->from);
        const Vector up = (from - last_touched_->position).normalized();
        const auto chord = workspace_.clip(from, up);
        const double out = chord ? std::max(chord->high, 0.0) : 0.0;
        const Point exit = from + out * up;
        if (say) say(back.length + out + workspace_.outer_distance(workspace_.nearest_boundary(exit), gate) + (home_ - gate).norm());
        follow(back.points, false);
        way += back.length;
        at_ = last_touched_->from;
        const Vector nearest = workspace_.nearest_boundary(from) - from;
        bool is_out = roadmap_.on_boundary(at_) || leave_along(up, way);
        if (!is_out && !nearest.isZero()) is_out = leave_along(nearest.normalized(), way);
        if (!is_out) is_out = leave_along(Vector::UnitZ(), way);
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

bool Tool::leave_along(const Vector& direction, double& way) {
    const NodeId from = at_;
    const auto chord = workspace_.clip(roadmap_.at(from), direction);
    if (!chord) return false;
    const ProbeAnswer answer = ask(roadmap_.at(from) + chord->high * direction, way);
    if (answer.outcome == ProbeAnswer::Outcome::clear) {
        const NodeId out = roadmap_.add_on_boundary(answer.position);
        roadmap_.connect(from, out);
        at_ = out;
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

void Tool::assign(std::uint32_t touch, Touch::Role role, std::uint32_t sample) {
    touches_[touch].role = role;
    touches_[touch].sample = sample;
    if (sample_starts_.size() <= sample) sample_starts_.resize(sample + 1, kNoNode);
    sample_starts_[sample] = touch_starts_[touch];
}

}  // namespace palpate
