#include "tools/terminal/consent.h"

#include <fmt/format.h>

#include "devices/errors.h"
#include "tools/terminal/terminal.h"

namespace palpate {
namespace {

// What was said before should stand above the question; a console that is held is no reason not to ask.
constexpr std::chrono::milliseconds kPatience{500};

}  // namespace

void ask_consent(const std::string& what_will_move, bool given, Console& console, StopSignals& signals) {
    if (given) return console.write(what_will_move + '\n');
    const std::optional<Terminal> terminal = Terminal::of_process();
    if (!terminal) throw SetupError("there is no terminal to ask on whether the machine may move: give --yes for unattended use");
    console.set_status({});
    (void)console.flush(kPatience);
    const std::string question = fmt::format("{}\nSpindle off, hand on the stop? Type yes to let the machine move: ", what_will_move);
    const std::string answer = terminal->ask(question, signals);
    if (signals.token().stop_requested()) throw Stopped("stopped at the question; nothing has moved");
    if (answer != "yes") throw SetupError("not confirmed; nothing has moved");
}

}  // namespace palpate
