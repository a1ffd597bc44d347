// Reads a session's YAML file. Strict: what it does not know, it refuses.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "config/config_error.h"
#include "config/session_config.h"

namespace palpate {

// Reads `file`, after putting `overrides` into it, each of the form "a.b.c=value" with a YAML value; later ones win.
// Relative paths, also those of overrides, are relative to the folder of `file`; the result holds absolute ones. Files
// that the configuration names are not looked at.
// Throws ConfigError on anything that config/README.md does not allow.
[[nodiscard]] SessionConfig read_config(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});

// The same for a text that is called `name` in messages, and whose relative paths are relative to the folder of `name`.
[[nodiscard]] SessionConfig read_config_text(const std::string& text, const std::filesystem::path& name,
                                             const std::vector<std::string>& overrides = {});

}  // namespace palpate
