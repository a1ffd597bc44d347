// Spells a configuration out, with every default, as it is kept in a session's folder.
#pragma once

#include <filesystem>
#include <string>

#include "config/session_config.h"

namespace palpate {

// YAML with all keys in a fixed order. For a config that respects the ranges of config/README.md, read_config returns
// the same values, bit for bit; a relative mesh path is taken from the working directory.
// Throws std::invalid_argument on a number that is not finite and on a file name that is not UTF-8, which YAML cannot hold.
[[nodiscard]] std::string write_config(const SessionConfig& config);
// The same for a text that will lie in `folder`: files are named relative to it, so that a tree that is moved or copied still fits, and has
// the same bytes. Absolute names of ports and devices stay.
[[nodiscard]] std::string write_config(const SessionConfig& config, const std::filesystem::path& folder);

// The key that a shape is written with: sphere, torus, …
[[nodiscard]] std::string shape_name(const ShapeSpec& shape);

}  // namespace palpate
