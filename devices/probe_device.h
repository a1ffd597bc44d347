// The seam between drivers and everything above them: one touch probe that moves.
#pragma once

#include <vector>

#include "planner/geometry.h"

namespace palpate {

// How fast a guarded move goes. Every one is guarded; these only name feeds, which a device knows in mm/s.
enum class Pace {
    travel,  // between probes, through space that has been proven free
    probe,   // towards a touch
    touch,   // slowly, to measure a touch again
};

// What happened on the way to an answer and did not change it. Kept for the account.
struct DeviceEvent {
    enum class Kind {
        spurious_trigger,  // the probe closed where nothing was when looked at again
        scattered_touch,   // touches of one place that lie apart farther than the tolerance
        repeated_command,  // an answer was lost; what the machine had done was found out, or asked for again
        reconnected,       // the connection was lost and is there again
    };
    Kind kind = Kind::spurious_trigger;
    Point position = Point::Zero();  // mm

    friend bool operator==(const DeviceEvent&, const DeviceEvent&) = default;
};

struct MoveResult {
    enum class Outcome {
        reached,
        contact,
        failed,  // something was touched, but where could not be measured (a device that measures touches more than once)
        // Something was touched, and twice nothing was there when looked at again: a false trigger, or the probe has just died.
        vanished,
    };
    Outcome outcome = Outcome::reached;
    Point position = Point::Zero();     // mm: the target, the touched point, or where it seemed to be
    std::vector<DeviceEvent> events{};  // in order
    // Of a contact: the probe was still closed when the tool stood. A spark on its lead is over by then, and so is a touch that only
    // grazes. A device that cannot tell says true.
    bool held = true;

    friend bool operator==(const MoveResult&, const MoveResult&) = default;
};

// A touch probe on a machine, real or simulated. There is no unguarded move (devices/FACTS.md, "Safety floor").
// Every call throws a DeviceError (devices/errors.h) on a fault.
class ProbeDevice {
public:
    virtual ~ProbeDevice() = default;

    // Where the tool rests, in mm. After a contact that is on the straight way to the touched point: at it, or before it where the
    // device retracts.
    [[nodiscard]] virtual Point position() const = 0;

    // Straight move from position() towards `target`; ends at the first contact. Touching nothing is not an error. A move of no
    // length reaches its target.
    [[nodiscard]] virtual MoveResult guarded_move(const Point& target, Pace pace) = 0;

    // Ends any motion, keeping the position trusted. Nothing moves afterwards until the next call.
    virtual void stop() = 0;
};

// After so many false triggers on one move it has failed.
inline constexpr int kMaxFalseTriggers = 8;

// On ground that was found to be free, what vanishes (Outcome::vanished) is a false trigger: the move is made again, a few times.
[[nodiscard]] inline MoveResult move_past_sparks(ProbeDevice& device, const Point& target, Pace pace) {
    MoveResult result = device.guarded_move(target, pace);
    for (int again = 0; result.outcome == MoveResult::Outcome::vanished && again < kMaxFalseTriggers; ++again) {
        result = device.guarded_move(target, pace);
    }
    return result;
}

}  // namespace palpate
