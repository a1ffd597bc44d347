// Nothing moves before the operator has agreed (DEVICES section 4).
#pragma once

#include <iosfwd>
#include <string>

namespace palpate {

// Shows what is about to happen, and asks for "yes" on a terminal; `given` (--yes) is that answer. Throws SetupError if the answer is
// another one, or there is nobody to ask.
void ask_consent(const std::string& what_will_move, bool given, std::istream& in, std::ostream& out, bool in_is_terminal);

}  // namespace palpate
