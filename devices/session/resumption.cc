#include "devices/session/resumption.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "devices/device_oracle.h"
#include "devices/errors.h"
#include "devices/session/datum.h"
#include "devices/session/drift_log.h"
#include "devices/session/part_frame.h"
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
// A probe may miss a touch.
constexpr int kAttempts = 2;

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
    // All but `recorded` is in the part's frame, which `drift` tells; without, that is the machine's.
    WayBack(GuardedMachine& guarded, const Journal& recorded, std::optional<DriftRecord> drift, const Surroundings& surroundings,
            const MachineSettings& settings, const Interruption& interruption)
        : machine_(guarded.machine()),
          device_(guarded.device()),
          drift_(std::move(drift)),
          frame_{drift_ ? drift_->log.shift() : Vector(Vector::Zero()), settings.limits},
          guarded_(device_, frame_),
          recorded_(recorded),
          in_part_frame_(drift_ ? in_part_frame(recorded, *drift_) : Journal{}),
          journal_(drift_ ? in_part_frame_ : recorded),
          surroundings_(surroundings),
          settings_(settings),
          interruption_(interruption),
          contradictions_(interruption.contradiction ? std::vector{*interruption.contradiction}
                                                     : std::vector<VisitedWays::Contradiction>{}),
          visited_ways_(journal_, surroundings, contradictions_),
          is_cut_off_(!visited_ways_.has_way(journal_.last_rest(), journal_.header.start)),
          datum_(choose_datum_places(journal_, visited_ways_, is_cut_off_ ? journal_.header.start : journal_.last_rest(),
                                     interruption.moves)) {}

    Return run() {
        const Point said = machine_.report().position;  // as it is now: the operator may have moved it by hand
        const Point at = frame_.to_part(said);
        const double beside = std::max(kBesideWay, 2 * DeviceOracle::kGraze * settings_.touch_error());
        const std::optional<Point> origin =
            machine_.is_position_trusted() ? origin_of(at, interruption_.next_target, beside) : std::nullopt;
        try {
            if (origin) {
                // The machine ended by itself what was under way, perhaps on the surface.
                check_limits(said);
                machine_.retreat(frame_.to_machine(*origin));
                machine_.make_ready();
                go(*origin);
                place_ = *origin;
                if (datum_touch_at(at, beside) != nullptr) go_round_to_start(*origin);
                if (is_cut_off_ && place_ == journal_.last_rest()) escape();
            } else {
                machine_.make_ready();
                check_limits(device_.position());
                enter(guarded_.position(), beside);
            }
        } catch (const UnexpectedContact&) {
            if (contradictions_.empty()) throw;
            escape();
        }
        std::vector<Point> datum = visit_datum();
        JournalResumption found = touch_datum();
        found.datum = std::move(datum);
        std::size_t moves = before_visit(believed_moves());
        while (!reaches(journal_.rest_before(moves))) moves = before_visit(std::min(moves - 1, believed_moves()));
        return {found, moves};
    }

private:
    // What drifted since the session ended is known from there on. The places that it was touched at; none if it never was before.
    std::vector<Point> visit_datum() {
        if (!drift_ || !drift_->log.has_reading() || !reaches(journal_.header.start)) return {};
        const DriftDatum& datum = *settings_.datum;
        std::vector<Point> touched;
        for (std::size_t k = 0; k < datum.touches.size(); ++k) {
            go(way_around(surroundings_, guarded_.position(), datum.touches[k].from));
            touched.push_back(touch_of_datum(datum.touches[k], k));
        }
        drift_->log.add(touched, drift_->end);
        frame_.shift = drift_->log.shift();
        go(way_around(surroundings_, guarded_.position(), journal_.header.start));
        // What was touched since the last visit is better known now.
        in_part_frame_ = in_part_frame(recorded_, *drift_);
        datum_ = choose_datum_places(journal_, visited_ways_, place_, interruption_.moves);
        return touched;
    }

    // As the machine says it.
    Point touch_of_datum(const DatumTouch& touch, std::size_t k) {
        for (int attempt = 0; attempt < kAttempts; ++attempt) {
            const MoveResult result = move_past_sparks(device_, frame_.to_machine(touch.to), Pace::probe);
            go(touch.from);
            if (result.outcome == Outcome::contact) return result.position;
        }
        throw DatumFault(
            fmt::format("machine.datum.at[{}]: nothing was touched from {} to {}: the datum is not there any more, or the probe does not "
                        "close any more. Put it back or mend the probe, then resume",
                        k, point_text(touch.from), point_text(touch.to)));
    }
    // The touch of the datum that a tool at `at` was left on.
    [[nodiscard]] const DatumTouch* datum_touch_at(const Point& at, double beside) const {
        if (!settings_.datum) return nullptr;
        for (const DatumTouch& touch : settings_.datum->touches)
            if (distance_to({touch.from, touch.to}, at) <= beside) return &touch;
        return nullptr;
    }

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
            datum_ = choose_datum_places(journal_, visited_ways_, place_, interruption_.moves);
        }
    }

    // No visit to the datum is believed in part.
    [[nodiscard]] std::size_t before_visit(std::size_t moves) const {
        const std::vector<JournalMove>& all = journal_.moves;
        while (moves > 0 && moves < all.size() && all[moves].datum && all[moves - 1].datum) --moves;
        return moves;
    }
    // None that passed a place that is touched now, and no rest that no way leads to any more.
    [[nodiscard]] std::size_t believed_moves() const {
        std::size_t moves = interruption_.moves;
        for (const VisitedWays::Contradiction& c : contradictions_)
            moves = std::min(moves, journal_.last_passed(c.touched, c.tolerance, moves).value_or(moves));
        std::vector<Point> rests;
        for (std::size_t k = 0; k <= moves; ++k) rests.push_back(journal_.rest_before(k));
        const std::vector<double> ways = visited_ways_.lengths(place_, rests);
        while (moves > 0 && !std::isfinite(ways[moves])) --moves;
        return moves;
    }
    // Between where its touch begins and where the tool comes to rest after it: an earlier resumption ended there. That is on no way of the
    // journal.
    [[nodiscard]] bool is_at(const DatumPlace& place, const Point& at, double beside) const {
        return distance_to({place.from, place.touched + settings_.motion.overtravel_mm * place.inwards}, at) <= beside;
    }
    // Where the move began that a tool at `at` was on, of those that may have ended without us.
    [[nodiscard]] std::optional<Point> origin_of(const Point& at, const Point& next_target, double beside) const {
        const Point rest = journal_.last_rest();
        if (distance_to({rest, next_target}, at) <= beside) return rest;
        if (const DatumTouch* touch = datum_touch_at(at, beside)) return touch->from;
        for (const DatumPlace& place : datum_) {
            if (is_at(place, at, beside)) return place.from;
        }
        return std::nullopt;
    }

    // The limits are a box: what leads from one place in it to another stays in it.
    void check_limits(const Point& at) const {
        if (settings_.limits.contains(at, settings_.motion.resolution_mm)) return;
        throw OutOfLimits(fmt::format(
            "the machine says that the tool is at {}, outside machine.limits. If it was reset or without power since, it does not know "
            "where "
            "it is: 1. home it; without switches, jog the tool to where the machine's 0, 0, 0 was, and reset it there; 2. jog the tool "
            "inside the limits, clear of the part; 3. resume: up to three known places are touched first, at the feed of probes, which "
            "shows "
            "whether position and part are as they were",
            point_text(at)));
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
            if (!contradictions_.empty() && !visited_ways_.has_way(place_, place)) escape();
            try {
                const std::optional<Point> touched = follow(visited_ways_.way(place_, place));
                if (!touched) {
                    place_ = place;
                    return;
                }
                if (contradictions_.empty() || met == kMaxMet) throw UnexpectedContact(*touched, kOnWayBack);
                contradictions_.push_back({*touched, contradictions_.front().tolerance, 0, journal_.moves.size()});
                visited_ways_ = VisitedWays(journal_, surroundings_, contradictions_);
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
        if (surroundings_.is_free(from)) return go_round_to_start(from);
        std::vector<std::pair<double, Vector>> ways;
        for (int k = 0; k < 27; ++k) {
            const Eigen::Vector3i step(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
            const Vector direction = step.cast<double>().normalized();
            if (direction.isZero()) continue;
            const auto chord = surroundings_.unknown_part(from, direction);
            if (chord && !surroundings_.first_known({from, from + chord->high * direction})) ways.emplace_back(chord->high, direction);
        }
        std::ranges::sort(ways, {}, &std::pair<double, Vector>::first);
        for (const auto& [length, direction] : ways) {
            if (move_past_sparks(guarded_, from + length * direction, Pace::probe).outcome != Outcome::reached) {
                go(from);
                continue;
            }
            return go_round_to_start(guarded_.position());
        }
        throw PositionLost(
            fmt::format("the tool is at {}, where no way out is known: a probe that missed the part led there. Move it outside by hand, "
                        "then resume",
                        point_text(from)));
    }

    // Around the workspace, from a place outside it.
    void go_round_to_start(const Point& at) {
        const Point out = surroundings_.nearest_entry(at);
        go(out);
        go(surroundings_.path(out, surroundings_.nearest_entry(journal_.header.start)));
        place_ = journal_.header.start;
        go(place_);
    }

    // From where the tool is to a place where the session has rested.
    void enter(const Point& at, double beside) {
        if (const auto move = visited_ways_.move_near(at, beside)) {
            place_ = move->source;
        } else if (const auto known = std::ranges::find_if(datum_, [&](const DatumPlace& p) { return is_at(p, at, beside); });
                   known != datum_.end()) {
            place_ = known->from;
        } else if (surroundings_.is_free(at) || (surroundings_.nearest_entry(at) - at).norm() <= beside) {
            // On a way around the workspace, too, which touches its boundary.
            return go_round_to_start(at);
        } else {
            throw PositionLost(
                fmt::format("the tool is at {}, inside the workspace and not on a way that this session has gone: move it outside by hand, "
                            "then resume",
                            point_text(at)));
        }
        go(place_);
    }

    // Touches a known place again, from its start, where the tool is. mm: how far off it is, along S's normal if that is known, else along
    // the way of the touch.
    double confirm(const DatumPlace& place) {
        const double tolerance = settings_.datum_tolerance();
        // Far enough to tell how far off it is; no deeper than the probe gives way, nor than the limits allow.
        const double wanted = std::min(settings_.motion.overtravel_mm, std::max(kLook * settings_.motion.overtravel_mm, 2 * tolerance));
        const double depth = std::min(wanted, room_within(settings_.limits, place.touched, place.inwards));
        const Point target = within(settings_.limits, place.touched + depth * place.inwards);
        MoveResult again = move_past_sparks(guarded_, target, Pace::probe);
        if (again.outcome != Outcome::contact) {
            // A probe may miss a touch.
            go(place.from);
            again = move_past_sparks(guarded_, target, Pace::probe);
        }
        const double slant = place.normal.isZero() ? 1.0 : std::abs(place.normal.dot(place.inwards));
        const double offset = slant * (again.position - place.touched).dot(place.inwards);
        if (again.outcome != Outcome::contact || std::abs(offset) > tolerance) {
            const bool is_touched = again.outcome == Outcome::contact;
            throw DeviceError(
                fmt::format("the place that was touched at {} (line {} of the journal) {} (tolerance {:g}, machine.datum_tolerance): the "
                            "part or the machine's origin has moved{}. Put it back, or begin a new session",
                            point_text(place.touched), place.line + 1,
                            is_touched ? fmt::format("is now touched {:g} mm off", std::abs(offset))
                                       : fmt::format("is not touched any more, within {:g} mm", depth),
                            tolerance, is_touched ? "" : ", or the probe does not close any more"));
        }
        go(place.from);
        return offset;
    }

    Machine& machine_;
    ProbeDevice& device_;  // as it says where it is
    std::optional<DriftRecord> drift_;
    PartFrame frame_;
    ShiftedDevice guarded_;
    const Journal& recorded_;
    Journal in_part_frame_;
    const Journal& journal_;
    const Surroundings surroundings_;
    const MachineSettings& settings_;
    const Interruption& interruption_;
    std::vector<VisitedWays::Contradiction> contradictions_;
    VisitedWays visited_ways_;
    const bool is_cut_off_;  // the last rest is beyond a place that a probe passed by mistake
    std::vector<DatumPlace> datum_;
    Point place_ = Point::Zero();  // where the session has rested, too, and the tool is
};

}  // namespace

Return return_to_work(GuardedMachine& guarded, const Journal& journal, const Surroundings& surroundings, const MachineSettings& settings,
                      const Interruption& interruption) {
    if (!settings.datum) return WayBack(guarded, journal, std::nullopt, surroundings, settings, interruption).run();
    DriftRecord drift = read_drift(journal, *settings.datum, settings.motion);
    Interruption in_part = interruption;
    in_part.next_target -= drift.log.shift();
    return WayBack(guarded, journal, std::move(drift), surroundings, settings, in_part).run();
}

}  // namespace palpate
