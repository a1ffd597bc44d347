// A session that begins, on a machine or in a simulation, whichever command begins it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/session_config.h"
#include "tools/commands/commands.h"

namespace palpate {

struct NewSession {
    SessionConfig config;                       // with what its files say
    std::vector<std::filesystem::path> inputs;  // files that it reads
    std::filesystem::path folder;
    PictureChoice picture;
    std::string earlier{};  // touches.csv of the session that it goes on from; empty: of the file that probing.earlier names, if it does
};

// Of a session that goes on from another's touches: their file is to be in its own folder. Returns what that file is to hold; empty: it
// goes on from none.
[[nodiscard]] std::string take_earlier(NewSession& session);

// They throw what the parts throw.
ExitCode begin_simulation(NewSession session, bool force, Output& output);
ExitCode begin_on_machine(NewSession session, bool yes, Output& output);

}  // namespace palpate
