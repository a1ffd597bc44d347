// The seam between drivers and everything above them: one touch probe that moves.
#pragma once

#include "planner/geometry.h"

namespace palpate {

struct MoveResult {
    enum class Outcome { reached, contact };
    Outcome outcome = Outcome::reached;
    Point position = Point::Zero();  // mm: the target, or the touched point. The tool rests there.
};

// A touch probe on a machine, real or simulated. There is no unguarded move (DEVICES section 4).
// Every call throws a DeviceError (devices/errors.h) on a fault.
class ProbeDevice {
public:
    virtual ~ProbeDevice() = default;

    // Where the tool rests, in mm.
    [[nodiscard]] virtual Point position() const = 0;

    // Straight move from position() towards `target`; ends at the first contact. Touching nothing is not an error.
    [[nodiscard]] virtual MoveResult guarded_move(const Point& target) = 0;

    // Ends any motion, keeping the position trusted. Nothing moves afterwards until the next call.
    virtual void stop() = 0;
};

}  // namespace palpate
