// A configuration as what a session on a machine is told.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "config/session_config.h"
#include "devices/session/machine_session.h"

namespace palpate {

// "machine.grbl or machine.modbus": the keys that say how a machine is reached.
[[nodiscard]] std::string connection_keys();
// Whether `key` is below one of them.
[[nodiscard]] bool is_connection_key(std::string_view key);

// ω of a configuration for a machine. Throws SetupError if there is no machine or ω is not given, and as check_session does.
[[nodiscard]] Region machine_workspace(const SessionConfig& config);

// For the session of a folder that holds its config.yaml. Throws as machine_workspace does.
[[nodiscard]] SessionPlan plan_session(const SessionConfig& config, const std::filesystem::path& folder);

}  // namespace palpate
