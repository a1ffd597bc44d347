// The machine that a configuration names: the driver for it, and what the operator is asked before it moves.
#pragma once

#include <memory>
#include <string>

#include "config/session_config.h"
#include "devices/machine.h"
#include "devices/session/machine_session.h"
#include "devices/stop_request.h"

namespace palpate {

// Reads what the connection names in files. Throws ConfigError.
void check_connection(const MachineConfig& config);
// Moves nothing, and says before on standard error what connecting may do, and how long it may take. Throws DeviceError, and as
// check_connection does.
[[nodiscard]] std::unique_ptr<Machine> connect(const MachineConfig& config, const StopToken& stop);

// What the operator is asked to agree to: the machine, where its tool is, how far and how fast it may go, what it will do, and homing if
// that comes first.
[[nodiscard]] std::string describe_plan(const PlannedMotion& plan, const SessionConfig& config);
[[nodiscard]] std::string describe_plan(const MachineReport& report, const MachineConfig& machine, const std::string& what);

}  // namespace palpate
