// The seam between the planner and whatever answers it: a machine, a ray caster, a recording.
#pragma once

#include <span>

#include "planner/geometry.h"

namespace palpate {

struct ProbeAnswer {
    enum class Outcome {
        contact,   // stopped by S
        clear,     // target reached, nothing touched
        failed,    // something was touched, but where could not be measured
        vanished,  // something was touched, and not again: a false trigger, or the probe has just died
    };
    Outcome outcome = Outcome::clear;
    Point position = Point::Zero();  // the touched point of S, the target, or (failed, vanished) the start; the tool is there now
};

// What shows that a way is free.
enum class Ground {
    proven,
    unconfirmed,  // clears alone, since the last contact: a probe that has died answers so, too
};

// What the planner may ask (DESIGN section 1, "probe"). The oracle has one tool, which is somewhere: every call starts
// where the last one ended. Calls throw what the answering side documents (a device fault, for instance).
class SurfaceOracle {
public:
    virtual ~SurfaceOracle() = default;

    // Where the tool is now.
    [[nodiscard]] virtual Point position() const = 0;

    // Moves through every point of `path` in turn, along straight lines. The planner has found the way free, so touching
    // anything on it is a fault of the oracle's, not an answer. Unconfirmed ground is crossed as slowly as a probe.
    virtual void travel(std::span<const Point> path, Ground ground) = 0;

    // Guarded straight move from position() towards `target`; stops at the first point of S.
    [[nodiscard]] virtual ProbeAnswer probe(const Point& target) = 0;

    // Asks for a proof from outside that contacts are noticed: the probe pressed by hand. False where nobody can give one.
    [[nodiscard]] virtual bool prove_alive() { return false; }
};

}  // namespace palpate
