// `object:` of a configuration.
#pragma once

#include <filesystem>

#include "config/internal/section.h"
#include "sim/object_spec.h"

namespace palpate::yaml {

// Throws ConfigError. A relative mesh path is taken from `folder`.
[[nodiscard]] ObjectSpec read_object(Section& section, const std::filesystem::path& folder);

}  // namespace palpate::yaml
