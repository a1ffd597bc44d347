// Names of files that a configuration holds: relative to its folder in a file, absolute in values.
#pragma once

#include <filesystem>

#include "config/session_config.h"

namespace palpate {

// `file`, a name relative to `folder`, as an absolute one. Links in folders are followed, where ".." means something else behind them; the
// file keeps its own name.
[[nodiscard]] std::filesystem::path absolute_name(const std::filesystem::path& file, const std::filesystem::path& folder);
// The name of an absolute `file` that absolute_name makes of it again: the same wherever both are moved together.
[[nodiscard]] std::filesystem::path relative_name(const std::filesystem::path& file, const std::filesystem::path& folder);

// All names in a configuration.
void make_names_absolute(SessionConfig& config, const std::filesystem::path& folder);
void make_names_relative(SessionConfig& config, const std::filesystem::path& folder);

}  // namespace palpate
