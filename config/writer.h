// Spells a configuration out, with every default, as it is kept in a session's folder.
#pragma once

#include <string>

#include "config/session_config.h"

namespace palpate {

// YAML with all keys in a fixed order. For a config that respects the ranges of config/README.md, read_config returns
// the same values, bit for bit; a relative mesh path is taken from the working directory.
// Throws std::invalid_argument on a number that is not finite and on a file name that is not UTF-8, which YAML cannot hold.
[[nodiscard]] std::string write_config(const SessionConfig& config);

}  // namespace palpate
