#include "tools/return_to_work.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "devices/datum.h"
#include "devices/device_oracle.h"
#include "devices/errors.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

using Outcome = MoveResult::Outcome;

// mm: what rounding and the last steps of an interrupted move put the tool beside its way, at least.
constexpr double kBesideWay = 0.05;

constexpr const char* kOnWayBack = "the way back to where the session ended";
// Where one touch was missed: so many things on known ways are gone around.
constexpr int kMaxMet = 8;
// Of the overtravel: so far beyond a known place its touch is looked for.
constexpr double kLook = 0.5;

// mm: how far it is from `p` along the unit vector `direction` to where `box` ends; 0 if `p` is there or beyond.
double room_within(const Box& box, const Point& p, const Vector& direction) {
    double room = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        if (direction[axis] == 0) continue;
        room = std::min(room, ((direction[axis] > 0 ? box.max : box.min)[axis] - p[axis]) / direction[axis]);
    }
    return std::max(0.0, room);
}

// Of a place that is outside by rounding.
Point within(const Box& box, const Point& p) { return p.cwiseMax(box.min).cwiseMin(box.max); }

class WayBack {
public:
    WayBack(GuardedMachine& guarded, const Journal& journal, const Workspace& workspace, const MachineConfig& config,
            const Interruption& interruption)
        : machine_(guarded.machine()),
          guarded_(guarded.device()),
          journal_(journal),
          workspace_(workspace),
          config_(config),
          interruption_(interruption),
          contradictions_(interruption.contradiction ? std::vector{*interruption.contradiction} : std::vector<Trail::Contradiction>{}),
          trail_(journal, workspace, contradictions_),
          is_cut_off_(!trail_.has_way(journal.last_rest(), journal.header.start)),
          datum_(choose_datum_places(journal, trail_, is_cut_off_ ? journal.header.start : journal.last_rest(), interruption.moves)) {}

    Return run() {
        const Point at = machine_.report().position;  // as it is now: the operator may have moved it by hand
        const double beside = std::max(kBesideWay, 2 * DeviceOracle::kGraze * config_.touch_error());
        const std::optional<Point> origin =
            machine_.is_position_trusted() ? origin_of(at, interruption_.next_target, beside) : std::nullopt;
        try {
            if (origin) {
                // The machine ended by itself what was under way, perhaps on the surface.
                check_limits(at);
                machine_.retreat(*origin);
                machine_.make_ready();
                go(*origin);
                place_ = *origin;
                if (is_cut_off_ && place_ == journal_.last_rest()) escape();
            } else {
                machine_.make_ready();
                check_limits(guarded_.position());
                enter(guarded_.position(), beside);
            }
        } catch (const UnexpectedContact&) {
            if (contradictions_.empty()) throw;
            escape();
        }
        const JournalResumption found = touch_datum();
        std::size_t moves = believed_moves();
        while (!reaches(journal_.rest_before(moves))) moves = std::min(moves - 1, believed_moves());
        return {found, moves};
    }

private:
    JournalResumption touch_datum() {
        for (int again = 0;; ++again) {
            JournalResumption found;
            found.directions = independent_directions(datum_);
            const bool all = std::ranges::all_of(datum_, [&](const DatumPlace& place) {
                if (!reaches(place.from)) return false;
                found.contacts.push_back(place.line);
                found.offsets_mm.push_back(confirm(place));
                return true;
            });
            if (all || again == kMaxMet) return found;
            // Less is known to be free than when they were chosen.
            datum_ = choose_datum_places(journal_, trail_, place_, interruption_.moves);
        }
    }

    // None that passed a place that is touched now, and no rest that no way leads to any more.
    [[nodiscard]] std::size_t believed_moves() const {
        std::size_t moves = interruption_.moves;
        for (const Trail::Contradiction& c : contradictions_)
            moves = std::min(moves, journal_.last_passed(c.touched, c.tolerance, moves).value_or(moves));
        std::vector<Point> rests;
        for (std::size_t k = 0; k <= moves; ++k) rests.push_back(journal_.rest_before(k));
        const std::vector<double> ways = trail_.lengths(place_, rests);
        while (moves > 0 && !std::isfinite(ways[moves])) --moves;
        return moves;
    }
    // Between where its touch begins and where the tool comes to rest after it: an earlier resumption ended there. That is on no way of the
    // journal.
    [[nodiscard]] bool is_at(const DatumPlace& place, const Point& at, double beside) const {
        return distance_to({place.from, place.touched + config_.kinematics.overtravel_mm * place.inwards}, at) <= beside;
    }
    // Where the move began that a tool at `at` was on, of those that may have ended without us.
    [[nodiscard]] std::optional<Point> origin_of(const Point& at, const Point& next_target, double beside) const {
        const Point rest = journal_.last_rest();
        if (distance_to({rest, next_target}, at) <= beside) return rest;
        for (const DatumPlace& place : datum_) {
            if (is_at(place, at, beside)) return place.from;
        }
        return std::nullopt;
    }

    // The limits are a box: what leads from one place in it to another stays in it.
    void check_limits(const Point& at) const {
        if (config_.limits.contains(at, config_.kinematics.resolution_mm)) return;
        throw OutOfLimits("the tool is at " + point_text(at) + ", outside machine.limits: move it inside them by hand, then resume");
    }

    // Nothing is trusted yet: at the feed of probes.
    void go(const Point& target) {
        if (guarded_.position() == target) return;
        const MoveResult result = move_past_sparks(guarded_, target, Pace::probe);
        if (result.outcome != Outcome::reached) throw UnexpectedContact(result.position, kOnWayBack);
    }

    void go(const std::vector<Point>& way) {
        for (const Point& p : way) go(p);
    }

    // From one place where the session has rested to another. Where a probe missed S once, it may have done so elsewhere: what is met on a
    // way then is gone around.
    void go_over_trail(const Point& place) {
        for (int met = 0; !(place_ == place); ++met) {
            if (!contradictions_.empty() && !trail_.has_way(place_, place)) escape();
            try {
                const std::optional<Point> touched = follow(trail_.way(place_, place));
                if (!touched) {
                    place_ = place;
                    return;
                }
                if (contradictions_.empty() || met == kMaxMet) throw UnexpectedContact(*touched, kOnWayBack);
                contradictions_.push_back({*touched, contradictions_.front().tolerance, 0, journal_.moves.size()});
                trail_ = Trail(journal_, workspace_, contradictions_);
            } catch (const UnexpectedContact&) {
                // Not even back to where that way began.
                if (contradictions_.empty() || met == kMaxMet) throw;
                escape();
            }
        }
    }

    // As that; false if what was met leaves no way there.
    [[nodiscard]] bool reaches(const Point& place) {
        try {
            go_over_trail(place);
            return true;
        } catch (const PositionLost&) {
            if (contradictions_.empty() || place == journal_.header.start) throw;
            return false;
        }
    }

    // Nothing if all of the way was free; else what was touched, and the tool is back where the way began.
    std::optional<Point> follow(const std::vector<Point>& way) {
        for (std::size_t k = 0; k < way.size(); ++k) {
            if (guarded_.position() == way[k]) continue;
            const MoveResult result = move_past_sparks(guarded_, way[k], Pace::probe);
            if (result.outcome == Outcome::reached) continue;
            if (contradictions_.empty()) return result.position;
            while (k-- > 0) go(way[k]);
            go(place_);
            return result.position;
        }
        return std::nullopt;
    }

    // No way that is known leads on from beyond what the probe has missed: straight out of the workspace, where that is nearest and free.
    void escape() {
        const Point from = guarded_.position();
        if (!workspace_.contains(from)) return go_round_to_start(from);
        std::vector<std::pair<double, Vector>> ways;
        for (int k = 0; k < 27; ++k) {
            const Vector direction = Vector(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1).normalized();
            if (direction.isZero()) continue;
            if (const auto chord = workspace_.clip(from, direction)) ways.emplace_back(chord->high, direction);
        }
        std::ranges::sort(ways, {}, &std::pair<double, Vector>::first);
        for (const auto& [length, direction] : ways) {
            if (move_past_sparks(guarded_, from + length * direction, Pace::probe).outcome != Outcome::reached) {
                go(from);
                continue;
            }
            return go_round_to_start(guarded_.position());
        }
        throw PositionLost("the tool is at " + point_text(from) +
                           ", where no way out is known: a probe that missed the part led there. Move it outside by hand, then resume");
    }

    // Around the workspace, from a place outside it.
    void go_round_to_start(const Point& at) {
        const Point out = workspace_.nearest_boundary(at);
        go(out);
        go(workspace_.outer_path(out, workspace_.nearest_boundary(journal_.header.start)));
        place_ = journal_.header.start;
        go(place_);
    }

    // From where the tool is to a place where the session has rested.
    void enter(const Point& at, double beside) {
        if (const auto move = trail_.move_near(at, beside)) {
            place_ = move->source;
        } else if (const auto known = std::ranges::find_if(datum_, [&](const DatumPlace& p) { return is_at(p, at, beside); });
                   known != datum_.end()) {
            place_ = known->from;
        } else if (!workspace_.contains(at) || (workspace_.nearest_boundary(at) - at).norm() <= beside) {
            // On a way around the workspace, too, which touches its boundary.
            return go_round_to_start(at);
        } else {
            throw PositionLost("the tool is at " + point_text(at) +
                               ", inside the workspace and not on a way that this session has gone: move it outside by hand, then resume");
        }
        go(place_);
    }

    // Touches a known place again, from its start, where the tool is. mm: how far off it is, along S's normal if that is known, else along
    // the way of the touch.
    double confirm(const DatumPlace& place) {
        const double tolerance = config_.datum_tolerance();
        // Far enough to tell how far off it is; no deeper than the probe gives way, nor than the limits allow.
        const double wanted = std::min(config_.kinematics.overtravel_mm, std::max(kLook * config_.kinematics.overtravel_mm, 2 * tolerance));
        const double depth = std::min(wanted, room_within(config_.limits, place.touched, place.inwards));
        const Point target = within(config_.limits, place.touched + depth * place.inwards);
        MoveResult again = move_past_sparks(guarded_, target, Pace::probe);
        if (again.outcome != Outcome::contact) {
            // A probe may miss a touch.
            go(place.from);
            again = move_past_sparks(guarded_, target, Pace::probe);
        }
        const double slant = place.normal.isZero() ? 1.0 : std::abs(place.normal.dot(place.inwards));
        const double offset = slant * (again.position - place.touched).dot(place.inwards);
        if (again.outcome != Outcome::contact || std::abs(offset) > tolerance) {
            std::ostringstream message;
            message << "the place that was touched at " << point_text(place.touched) << " (line " << place.line + 1 << " of the journal) ";
            if (again.outcome == Outcome::contact) {
                message << "is now touched " << std::abs(offset) << " mm off";
            } else {
                message << "is not touched any more, within " << depth << " mm";
            }
            message << " (tolerance " << tolerance << ", machine.datum_tolerance): the part or the machine's origin has moved"
                    << (again.outcome == Outcome::contact ? "" : ", or the probe does not close any more")
                    << ". Put it back, or begin a new session";
            throw DeviceError(message.str());
        }
        go(place.from);
        return offset;
    }

    Machine& machine_;
    ProbeDevice& guarded_;
    const Journal& journal_;
    const Workspace& workspace_;
    const MachineConfig& config_;
    const Interruption& interruption_;
    std::vector<Trail::Contradiction> contradictions_;
    Trail trail_;
    const bool is_cut_off_;  // the last rest is beyond a place that a probe passed by mistake
    std::vector<DatumPlace> datum_;
    Point place_ = Point::Zero();  // where the session has rested, too, and the tool is
};

}  // namespace

Return return_to_work(GuardedMachine& guarded, const Journal& journal, const Workspace& workspace, const MachineConfig& config,
                      const Interruption& interruption) {
    return WayBack(guarded, journal, workspace, config, interruption).run();
}

}  // namespace palpate
