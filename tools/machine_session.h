// A session on a machine: started, interrupted, taken up again, or replayed from its journal without a machine.
#pragma once

#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "config/session_config.h"
#include "devices/journal.h"
#include "devices/metered_device.h"
#include "planner/prober.h"
#include "tools/machine.h"

namespace palpate {

struct MachineRun {
    Result result;
    Meter meter;               // of the answers that the planner got, replayed ones too
    std::uint64_t grazes = 0;  // touches on travel that were passed beside
    std::vector<JournalResumption> resumptions;
    std::string machine;  // identity
    double planner_seconds = 0.0;
    double oracle_seconds = 0.0;
};

// Whoever runs a session.
struct SessionHost {
    std::function<void(const Progress&)> on_progress;      // may be empty
    std::function<void(const std::string& plan)> ask;      // asks the operator before anything moves; throws if the answer is no
    std::function<void(const std::string& sentence)> say;  // what the operator may want to know
    // Has the probe pressed by hand, and says whether it was seen to close and to open; empty: nobody can be asked.
    std::function<bool(Machine&)> press;
    std::stop_token stop;
};

// ω of a configuration for a machine. Throws SetupError if there is no machine, ω is not given, or the tool may not go all around it;
// std::invalid_argument as check_options does.
[[nodiscard]] Workspace machine_workspace(const SessionConfig& config);

// A new session in a folder that holds its config.yaml; makes journal.jsonl there. Throws DeviceError on a fault, after which the session
// can be resumed if the journal was begun, and what probe_surface throws.
[[nodiscard]] MachineRun start_session(const SessionConfig& config, const std::filesystem::path& folder, const SessionHost& host);
// Takes up a session where its journal ends: replays it, brings the tool back, touches known places again, and goes on. What was found free
// since the last contact is asked again. One that is finished is replayed.
[[nodiscard]] MachineRun resume_session(const SessionConfig& config, const std::filesystem::path& folder, const SessionHost& host);
// The same result again, from the journal of a session that was finished.
[[nodiscard]] MachineRun replay_session(const SessionConfig& config, const std::filesystem::path& folder, const SessionHost& host);

// How often known places were touched again because a probe had missed a touch.
[[nodiscard]] std::size_t missed_touches(const std::vector<JournalResumption>& resumptions);

}  // namespace palpate
