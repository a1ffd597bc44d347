// Brings the tool of an interrupted session back to where what is to be believed of it ends, over ways that it has gone before, and touches
// known places again: neither the part nor the origin may have moved.
#pragma once

#include "devices/session/guarded_machine.h"
#include "devices/session/journal.h"
#include "devices/session/machine_settings.h"
#include "devices/session/visited_ways.h"
#include "planner/surroundings.h"

namespace palpate {

struct Interruption {
    Point next_target =
        Point::Zero();      // the machine's, where the next move goes: an interrupted session may have left the tool on the way there
    std::size_t moves = 0;  // of the journal, that are to be believed at most
    std::optional<VisitedWays::Contradiction> contradiction{};  // in the part's frame (drift_log.h)
};

struct Return {
    JournalResumption found;
    std::size_t moves = 0;  // of the journal, that are to be believed: the tool is where they end
};

// With settings.datum the datum is touched first, and drift taken out of what follows.
// All ways are gone at the feed of probes. Throws DeviceError if the tool is where no way back is known, if something is in the way, if
// a known place has moved by more than the tolerance, or as a visit to the datum does.
[[nodiscard]] Return return_to_work(GuardedMachine& guarded, const Journal& journal, const Surroundings& surroundings,
                                    const MachineSettings& settings, const Interruption& interruption);

}  // namespace palpate
