#include "tools/return_to_work.h"

#include <algorithm>
#include <limits>
#include <sstream>

#include "devices/device_oracle.h"
#include "devices/errors.h"
#include "devices/trail.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

using Outcome = MoveResult::Outcome;

// mm: what rounding and the last steps of an interrupted move put the tool beside its way, at least.
constexpr double kBesideWay = 0.05;

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

class Return {
public:
    Return(GuardedMachine& guarded, const Journal& journal, const Workspace& workspace, const MachineConfig& config)
        : machine_(guarded.machine()),
          guarded_(guarded.device()),
          journal_(journal),
          workspace_(workspace),
          config_(config),
          known_(known_place(journal)),
          trail_(journal) {}

    Confirmation run(const Point& next_target) {
        const Point at = machine_.report().position;  // as it is now: the operator may have moved it by hand
        const double beside = std::max(kBesideWay, 2 * DeviceOracle::kGraze * config_.touch_error());
        const std::optional<Point> origin = machine_.is_position_trusted() ? origin_of(at, next_target, beside) : std::nullopt;
        if (origin) {
            // The machine ended by itself what was under way, perhaps on the surface.
            check_limits(at);
            machine_.retreat(*origin);
            machine_.make_ready();
            go_on_from(*origin);
        } else {
            machine_.make_ready();
            check_limits(guarded_.position());
            enter(guarded_.position(), beside);
        }
        return confirm();
    }

    // Out of ω again, over ways that were gone.
    void leave() { go(trail_.way(journal_.last_rest(), journal_.header.start)); }

private:
    // The last touch, which is made again: neither the part nor the origin may have moved.
    struct KnownPlace {
        std::uint64_t line = 0;  // of the journal
        Point from = Point::Zero();
        Point touched = Point::Zero();
        Vector inwards = Vector::Zero();  // unit length
    };
    [[nodiscard]] static std::optional<KnownPlace> known_place(const Journal& journal) {
        const auto last = journal.last_contact();
        if (!last) return std::nullopt;
        const JournalMove& move = journal.moves[*last];
        const Point from = *last == 0 ? journal.header.start : journal.moves[*last - 1].rest;
        return KnownPlace{move.line, from, move.result.position, (move.result.position - from).normalized()};
    }
    // Between where the touch begins and where the tool comes to rest after it: an earlier resumption ended there. That is on no way of the
    // journal.
    [[nodiscard]] bool is_at_known_place(const Point& at, double beside) const {
        return known_ && distance_to({known_->from, known_->touched + config_.kinematics.overtravel_mm * known_->inwards}, at) <= beside;
    }
    // Where the move began that a tool at `at` was on, of those that may have ended without us.
    [[nodiscard]] std::optional<Point> origin_of(const Point& at, const Point& next_target, double beside) const {
        const Point rest = journal_.last_rest();
        if (distance_to({rest, next_target}, at) <= beside) return rest;
        if (is_at_known_place(at, beside)) return known_->from;
        return std::nullopt;
    }

    // The limits are a box: what leads from one place in it to another stays in it.
    void check_limits(const Point& at) const {
        if (config_.limits.contains(at, config_.kinematics.resolution_mm)) return;
        throw OutOfLimits("the tool is at " + point_text(at) + ", outside machine.limits: move it inside them by hand, then resume");
    }

    void go(const Point& target) {
        if (guarded_.position() == target) return;
        const MoveResult result = guarded_.guarded_move(target, Pace::travel);
        if (result.outcome != Outcome::reached) throw UnexpectedContact(result.position, "the way back to where the session ended");
    }

    void go(const std::vector<Point>& way) {
        for (const Point& p : way) go(p);
    }

    // To where the session ended, from a place that it has rested at.
    void go_on_from(const Point& place) {
        go(place);
        go(trail_.way(place, journal_.last_rest()));
    }

    // From where the tool is to where the session ended.
    void enter(const Point& at, double beside) {
        if (const auto move = trail_.move_near(at, beside)) {
            go_on_from(move->source);
        } else if (is_at_known_place(at, beside)) {
            go_on_from(known_->from);
        } else if (!workspace_.contains(at)) {
            const Point start = journal_.header.start;
            const Point out = workspace_.nearest_boundary(at);
            const Point in = workspace_.nearest_boundary(start);
            go(out);
            go(workspace_.outer_path(out, in));
            go_on_from(start);
        } else {
            throw PositionLost("the tool is at " + point_text(at) +
                               ", inside the workspace and not on a way that this session has gone: move it outside by hand, then resume");
        }
    }

    Confirmation confirm() {
        if (!known_) return {};
        const auto& [line, from, touched, inwards] = *known_;
        const Point rest = journal_.last_rest();
        go(trail_.way(rest, from));
        const double tolerance = config_.datum_tolerance_mm;
        // No deeper than would be too deep, nor than the limits allow.
        const double depth = std::min(2 * tolerance, room_within(config_.limits, touched, inwards));
        const MoveResult again = guarded_.guarded_move(within(config_.limits, touched + depth * inwards), Pace::probe);
        const double offset = (again.position - touched).dot(inwards);
        if (again.outcome != Outcome::contact || std::abs(offset) > tolerance) {
            std::ostringstream message;
            message << "the place that was touched at " << point_text(touched) << " (line " << line + 1 << " of the journal) "
                    << (again.outcome == Outcome::contact ? "is now touched " : "is not touched any more, within ")
                    << (again.outcome == Outcome::contact ? std::abs(offset) : depth) << " mm off (tolerance " << tolerance
                    << ", machine.datum_tolerance): the part or the machine's origin has moved. Put it back, or begin a new session";
            throw DeviceError(message.str());
        }
        go(from);
        go(trail_.way(from, rest));
        return {line, offset};
    }

    Machine& machine_;
    ProbeDevice& guarded_;
    const Journal& journal_;
    const Workspace& workspace_;
    const MachineConfig& config_;
    const std::optional<KnownPlace> known_;
    const Trail trail_;
};

}  // namespace

Confirmation return_to_work(GuardedMachine& guarded, const Journal& journal, const Workspace& workspace, const MachineConfig& config,
                            const Point& next_target) {
    return Return(guarded, journal, workspace, config).run(next_target);
}

void leave_work(GuardedMachine& guarded, const Journal& journal, const Workspace& workspace, const MachineConfig& config) {
    Return(guarded, journal, workspace, config).leave();
}

}  // namespace palpate
