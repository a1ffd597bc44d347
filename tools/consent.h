// Nothing moves before the operator has agreed (devices/FACTS.md, "Safety floor").
#pragma once

#include <iosfwd>
#include <stop_token>
#include <string>

namespace palpate {

// Shows what is about to happen, and asks for "yes" on a terminal, the file descriptor `in`; `given` (--yes) is that answer. Throws
// SetupError if the answer is another one, if a stop is requested meanwhile, or if there is nobody to ask.
void ask_consent(const std::string& what_will_move, bool given, int in, std::ostream& out, const std::stop_token& stop);

}  // namespace palpate
