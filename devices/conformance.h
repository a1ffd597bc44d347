// Whether a machine and its driver do what a session relies on: tried on the machine itself, in space that is free, without a part.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "devices/clock.h"
#include "devices/machine.h"
#include "devices/motion_model.h"
#include "devices/stop_request.h"
#include "planner/region.h"

namespace palpate {

struct ConformanceOptions {
    MotionModel motion;
    Box limits;              // mm: the tool stays in there
    double reach_mm = 10.0;  // > 0: so far at most from where the tool stands
    Seconds hand{30};        // a hand is waited for so long
};

struct Conformance {
    enum class Verdict {
        good,
        bad,
        skipped,
    };
    Verdict verdict = Verdict::good;
    std::string what;  // "goes where it is told"
    std::string why;   // of what is bad or skipped; of what is good, what was measured, or nothing
};

// What somebody at the machine does, and who is told.
struct ConformanceAudience {
    std::function<void(const Conformance&)> tell;
    enum class Hand {
        hold,    // holds the probe closed
        let_go,  // ... no more
        tap,     // presses it once, for half a second at most
    };
    // Asks for that, and does not wait for it. Empty: nobody is there.
    std::function<void(Hand)> ask_hand{};
};

// Makes the machine ready, moves it, guarded, to and fro within reach of where it stands, and stops it in mid-move. `connect` connects
// anew, every time, with the stop token that it is given; nothing may be connected before. `clock` tells how long moves take. What throws
// is bad, and told. False if anything was bad: it ends there, as nobody knows what another move would do. `stop`: ends it, and throws
// Stopped.
[[nodiscard]] bool try_conformance(const std::function<std::unique_ptr<Machine>(const StopToken&)>& connect, Clock& clock,
                                   const ConformanceOptions& options, const ConformanceAudience& audience, const StopToken& stop = {});

}  // namespace palpate
