#include "tools/consent.h"

#include <istream>
#include <ostream>

#include "tools/simulation.h"

namespace palpate {

void ask_consent(const std::string& what_will_move, bool given, std::istream& in, std::ostream& out, bool in_is_terminal) {
    out << what_will_move << '\n';
    if (given) return;
    if (!in_is_terminal) throw SetupError("nobody can be asked whether the machine may move: give --yes for unattended use");
    out << "Spindle off, hand on the stop? Type yes to let the machine move: " << std::flush;
    std::string answer;
    std::getline(in, answer);
    if (answer != "yes") throw SetupError("not confirmed; nothing has moved");
}

}  // namespace palpate
