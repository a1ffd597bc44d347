// The machine that a configuration names: the driver for it, and what the operator is asked before it moves.
#pragma once

#include <memory>
#include <stop_token>
#include <string>

#include "config/machine_config.h"
#include "devices/machine.h"
#include "devices/session/machine_session.h"

namespace palpate {

// Reads what the connection names in files. Throws ConfigError.
void check_connection(const MachineConfig& config);
// Moves nothing. Throws DeviceError, and as check_connection does.
[[nodiscard]] std::unique_ptr<Machine> connect(const MachineConfig& config, const std::stop_token& stop);

// What the operator is asked to agree to: the machine, where its tool is, what it will do, and homing if that comes first.
[[nodiscard]] std::string describe_plan(const PlannedMotion& plan);
[[nodiscard]] std::string describe_plan(const MachineReport& report, bool homes_first, const std::string& what);

}  // namespace palpate
