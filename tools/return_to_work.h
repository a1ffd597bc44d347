// Brings the tool of a resumed session back to where its last contact left it, over ways that it has gone before, and touches known places
// again: neither the part nor the origin may have moved.
#pragma once

#include "config/machine_config.h"
#include "devices/journal.h"
#include "planner/workspace.h"
#include "tools/machine.h"

namespace palpate {

// `next_target` is where the next move goes: an interrupted session may have left the tool on the way there. All ways are gone at the feed of
// probes. The tool rests at journal.confirmed_rest() then. Throws DeviceError if the tool is where no way back is known, if something is in
// the way, or if a known place has moved by more than the tolerance.
[[nodiscard]] JournalResumption return_to_work(GuardedMachine& guarded, const Journal& journal, const Workspace& workspace,
                                               const MachineConfig& config, const Point& next_target);

}  // namespace palpate
