// `machine:` of a configuration.
#pragma once

#include <filesystem>

#include "config/internal/section.h"
#include "config/machine_config.h"

namespace palpate::yaml {

// Throws ConfigError. A relative path of a profile is taken from `folder`.
[[nodiscard]] MachineConfig read_machine(Section& section, const std::filesystem::path& folder);

}  // namespace palpate::yaml
