// A session on a machine with somebody beside it: asked before anything moves, told what happens, able to stop it.
#pragma once

#include <filesystem>
#include <iosfwd>

#include "config/session_config.h"
#include "devices/session/machine_session.h"
#include "tools/commands/commands.h"
#include "tools/stop_signals.h"

namespace palpate {

// `yes`: the operator has agreed in advance. Both arguments that are references must outlive the host.
[[nodiscard]] SessionHost host_for(const MachineConfig& machine, bool yes, const StopSignals& signals);

// Runs a session (start_session, resume_session, replay_session) in its folder, says how to go on if it is interrupted, and writes what it
// found. Throws what that throws.
ExitCode run_session(const std::filesystem::path& folder, const SessionConfig& config, const PictureChoice& picture, SessionHost host,
                     std::ostream& out, MachineRun (*session)(const SessionPlan&, const SessionHost&));

}  // namespace palpate
