// What a configuration says of the space around the part: ω, and the solids that stand in it.
#pragma once

#include <string>

#include "config/session_config.h"
#include "planner/surroundings.h"

namespace palpate {

// `workspace`: as the configuration gives it, or fitted to a hidden object. Throws SetupError where the fixtures leave nothing to probe, or
// no way out.
[[nodiscard]] Surroundings surroundings_of(const SessionConfig& config, const Region& workspace);

// For people: "around (0, 0, 20), radius 40 mm".
[[nodiscard]] std::string describe(const Surroundings& surroundings);

}  // namespace palpate
