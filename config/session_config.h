// Everything that one session is told: what to probe, where, how. The reader fills it, the writer spells it out.
#pragma once

#include <cstdint>
#include <optional>
#include <variant>

#include "planner/options.h"
#include "planner/workspace.h"
#include "sim/object_spec.h"

namespace palpate {

// ω is derived from the hidden object. Only a simulation can do that.
struct AutoWorkspace {};

using WorkspaceSpec = std::variant<AutoWorkspace, Ball, Box>;

struct SessionConfig {
    std::optional<ObjectSpec> object;  // the hidden object of a simulation; nothing on a real machine
    WorkspaceSpec workspace;
    Options probing;
};

}  // namespace palpate
