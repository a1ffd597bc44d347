// Brings the tool of a resumed session back to where its journal ends, over ways that it has gone before, and touches a known place
// again: neither the part nor the origin may have moved.
#pragma once

#include <cstdint>
#include <optional>

#include "config/machine_config.h"
#include "devices/journal.h"
#include "planner/workspace.h"
#include "tools/machine.h"

namespace palpate {

struct Confirmation {
    std::optional<std::uint64_t> contact_line;  // of the journal; nothing if there was no touch yet
    double offset_mm = 0.0;                     // along the probe's way, between then and now
};

// `next_target` is where the next move goes: an interrupted session may have left the tool on the way there. Throws DeviceError if the
// tool is where no way back is known, if something is in the way, or if the known place has moved by more than the tolerance.
[[nodiscard]] Confirmation return_to_work(GuardedMachine& guarded, const Journal& journal, const Workspace& workspace,
                                          const MachineConfig& config, const Point& next_target);

// From where a session ended back to where it began, outside ω, so that the next can begin there. Throws as above.
void leave_work(GuardedMachine& guarded, const Journal& journal, const Workspace& workspace, const MachineConfig& config);

}  // namespace palpate
