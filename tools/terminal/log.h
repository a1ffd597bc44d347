// Messages and warnings: to the console, in colour where that tells a warning from the rest, and as events.
#pragma once

#include "tools/terminal/output.h"

namespace palpate {

// What is logged goes there from now on. `output` must outlive all logging.
void log_to(Output& output);

}  // namespace palpate
