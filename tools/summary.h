// summary.json: counts, certificate, times, and what only one kind of run knows (planner/DESIGN.md, "Session folder").
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "devices/session/machine_session.h"
#include "planner/certificate.h"
#include "tools/part_result.h"
#include "tools/provenance.h"
#include "tools/simulation.h"

namespace palpate {

// JSON with the keys of planner/DESIGN.md, "Session folder".
[[nodiscard]] std::string to_json(const Simulation& run, const std::optional<PartResult>& part, double epsilon,
                                  const Provenance& provenance);
[[nodiscard]] std::string to_json(const MachineRun& run, const std::optional<PartResult>& part, double epsilon,
                                  const Provenance& provenance);
[[nodiscard]] nlohmann::ordered_json to_json(const ToolAccount& tool);

[[nodiscard]] const char* to_string(Certificate::Status status);
[[nodiscard]] const char* to_string(Premise::State state);

}  // namespace palpate
