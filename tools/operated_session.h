// A session on a machine with somebody beside it: asked before anything moves, told what happens, able to stop it.
#pragma once

#include <filesystem>

#include "config/session_config.h"
#include "devices/session/machine_session.h"
#include "tools/commands/commands.h"
#include "tools/terminal/stop_signals.h"

namespace palpate {

// `yes`: the operator has agreed in advance. Arguments that are references must outlive the host.
[[nodiscard]] SessionHost host_for(const SessionConfig& config, bool yes, Output& output, StopSignals& signals);

// Runs a session (start_session, resume_session, replay_session), planned from `config`, in its folder, says how to go on if it is
// interrupted, and writes what it found. Once nothing moves any more, `signals` are released. Throws what that throws.
ExitCode run_session(const SessionPlan& plan, const SessionConfig& config, const std::filesystem::path& folder,
                     const PictureChoice& picture, SessionHost host, Output& output, StopSignals& signals,
                     MachineRun (*session)(const SessionPlan&, const SessionHost&));

}  // namespace palpate
