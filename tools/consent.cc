#include "tools/consent.h"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <ostream>

#include "devices/errors.h"

namespace palpate {
namespace {

// So often a stop is looked for while nobody answers.
constexpr int kPoll_ms = 50;

// A line, or what came before the end of the file or a stop.
std::string read_line(int in, const std::stop_token& stop) {
    std::string line;
    while (!stop.stop_requested()) {
        pollfd waiting{in, POLLIN, 0};
        if (::poll(&waiting, 1, kPoll_ms) <= 0) continue;
        std::array<char, 1> c{};
        if (::read(in, c.data(), 1) != 1 || c[0] == '\n') break;
        line += c[0];
    }
    return line;
}

}  // namespace

void ask_consent(const std::string& what_will_move, bool given, int in, std::ostream& out, const std::stop_token& stop) {
    out << what_will_move << '\n';
    if (given) return;
    if (::isatty(in) == 0) throw SetupError("nobody can be asked whether the machine may move: give --yes for unattended use");
    out << "Spindle off, hand on the stop? Type yes to let the machine move: " << std::flush;
    if (read_line(in, stop) != "yes") throw SetupError("not confirmed; nothing has moved");
}

}  // namespace palpate
