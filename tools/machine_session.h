// A session on a machine: started, interrupted, taken up again, or replayed from its journal without a machine.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <stop_token>

#include "config/session_config.h"
#include "devices/metered_device.h"
#include "planner/prober.h"

namespace palpate {

struct MachineRun {
    Result result;
    Meter meter;               // of the answers that the planner got, replayed ones too
    std::uint64_t grazes = 0;  // touches on travel that were passed beside
    std::uint64_t resumptions = 0;
    std::string machine;  // identity
    double planner_seconds = 0.0;
    double oracle_seconds = 0.0;
};

// What a session needs from whoever runs it.
struct SessionContext {
    std::function<void(const Progress&)> on_progress;  // may be empty
    // Asks the operator before anything moves: what the machine is, and what it will do. Throws if the answer is no.
    std::function<void(const std::string& what_will_move)> ask;
    std::function<void(const std::string& note)> say;
    std::stop_token stop;
};

// ω of a configuration for a machine. Throws SetupError if there is no machine, ω is not given, or the tool may not go all around it.
[[nodiscard]] Workspace machine_workspace(const SessionConfig& config);

// A new session. `folder` holds its config.yaml and gets journal.jsonl. Throws DeviceError on a fault, after which the session can be
// resumed, and what probe_surface throws.
[[nodiscard]] MachineRun start_session(const SessionConfig& config, const std::filesystem::path& folder, const SessionContext& context);
// Takes up a session where its journal ends: replays it, brings the tool back, touches a known place again, and goes on.
[[nodiscard]] MachineRun resume_session(const SessionConfig& config, const std::filesystem::path& folder, const SessionContext& context);
// The same result again from a journal that was finished, without a machine.
[[nodiscard]] MachineRun replay_session(const SessionConfig& config, const std::filesystem::path& folder, const SessionContext& context);

}  // namespace palpate
