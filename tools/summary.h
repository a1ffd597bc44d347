// summary.json: counts, certificate, times, and what only one kind of run knows (DESIGN section 9).
#pragma once

#include <string>

#include "planner/certificate.h"
#include "tools/machine_session.h"
#include "tools/simulation.h"

namespace palpate {

// JSON with the keys of DESIGN section 9, and some more.
[[nodiscard]] std::string to_json(const Simulation& run, double epsilon);
[[nodiscard]] std::string to_json(const MachineRun& run, double epsilon);

[[nodiscard]] const char* to_string(Certificate::Status status);
[[nodiscard]] const char* to_string(Premise::State state);

}  // namespace palpate
