// A session that begins, on a machine or in a simulation, whichever command begins it.
#pragma once

#include <filesystem>
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
    std::string earlier{};  // what kEarlierFile is to hold in its folder; empty: it goes on from no other session
};

// As a configuration file says. Throws what read_config and with_its_files throw.
[[nodiscard]] NewSession new_session(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                                     const std::filesystem::path& folder, const PictureChoice& picture);
// Has it go on from touches, touches.csv of another session. It keeps them in its own folder.
void keep_earlier(NewSession& session, std::string touches);

// They throw what the parts throw.
ExitCode begin_simulation(const NewSession& session, bool force, Output& output);
ExitCode begin_on_machine(const NewSession& session, bool yes, Output& output);

}  // namespace palpate
