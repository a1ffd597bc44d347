// The seam between the planner and whatever answers it: a machine, a ray caster, a recording.
#pragma once

#include <optional>
#include <span>

#include "planner/geometry.h"
#include "planner/machine_time.h"

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

// What is known of an oracle beforehand, said once: the planner reckons with it. The defaults are those of an exact ray caster.
struct OracleTraits {
    double touch_error = 0.0;  // mm: touches may lie beside S by that, and the tool beside its line
    double retract = 0.0;      // mm: the tool lifts off a touch at least so far before it goes elsewhere
    // mm: what the probe gives way after a touch. Given: the probe may die, and has to be shown to work again and again
    // (planner/DESIGN.md, "A probe that may die").
    std::optional<double> overtravel;
    MachineRates rates;  // what a budget of machine time is reckoned with
};

// What the planner may ask (planner/DESIGN.md, "Terms"). The oracle has one tool, which is somewhere: every call starts
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

    [[nodiscard]] virtual OracleTraits traits() const = 0;

    // Asks for a proof from outside that contacts are noticed: the probe pressed by hand. False where nobody can give one.
    [[nodiscard]] virtual bool prove_alive() { return false; }
};

}  // namespace palpate
