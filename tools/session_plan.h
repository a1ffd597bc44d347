// A configuration as what a session on a machine is told.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "config/session_config.h"
#include "devices/session/machine_session.h"

namespace palpate {

// "machine.grbl or machine.modbus": the keys that say how a machine is reached.
[[nodiscard]] std::string connection_keys();
// Whether `key` is below one of them.
[[nodiscard]] bool is_connection_key(std::string_view key);

// ω of a configuration for a machine. Throws SetupError if there is no machine or ω is not given, and as check_session does.
[[nodiscard]] Surroundings machine_workspace(const SessionConfig& config);

// With what the files say that it names: a calibration, touches of an earlier session. Throws CalibrationError, SetupError.
[[nodiscard]] SessionConfig with_its_files(SessionConfig config);

// The files that a run reads.
[[nodiscard]] std::vector<std::filesystem::path> inputs_of(const SessionConfig& config, const std::filesystem::path& file);

// What a session will take if the part fills ω, roughly: the operator is to know whether it is minutes or hours. A budget may end it
// before.
struct ExpectedEffort {
    double touches = 0.0;
    Seconds time{0};
};
[[nodiscard]] ExpectedEffort expected_effort(const SessionConfig& config);
// "about 1,500 touches in 2 h of motion if the part fills the workspace"
[[nodiscard]] std::string effort_text(const SessionConfig& config);
// The same of a simulation, whose object is known: "about 1,500 touches". `size`: of its bounding box, mm.
[[nodiscard]] std::string effort_text(const Options& options, const Vector& size);

// A larger budget than one that was used up, as a word for --set.
[[nodiscard]] std::string larger_budget(const Budget& budget);

// For the session of a folder whose config.yaml has that text. Throws as machine_workspace does.
[[nodiscard]] SessionPlan plan_session(const SessionConfig& config, const std::filesystem::path& folder, const std::string& text);

}  // namespace palpate
