// The touches of an earlier session, for one that goes on from them (planner/DESIGN.md, "Going on"). They are read by what they are, not
// replayed: whichever version of the program made them, and whatever it had decided.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "config/session_config.h"
#include "planner/options.h"

namespace palpate {

// What was touched in the session of that folder, as touches.csv has it: that file of a session that came to its end, else what its journal
// says, and what it went on from itself. Throws SetupError if the folder has neither, or drift has to be taken out yet; JournalDamaged,
// JournalError.
[[nodiscard]] std::string earlier_touches_in(const std::filesystem::path& folder);

// Columns x, y, z, from_x, from_y, from_z (mm), by their names; with `sample`, what has none there is no sample; with `tag`, fixtures and
// walls of an area are left out. Other columns may be there. Throws SetupError, which begins with `name` and the line.
[[nodiscard]] std::vector<EarlierTouch> parse_touches(const std::string& csv, const std::string& name);

// The configuration with what its probing.earlier says, if it names one. Throws SetupError.
[[nodiscard]] SessionConfig with_earlier_touches(SessionConfig config);

}  // namespace palpate
