#include "tools/terminal/consent.h"

#include <fmt/format.h>

#include "devices/errors.h"
#include "tools/terminal/terminal.h"

namespace palpate {
namespace {

// What was said before should stand above the question; a console that is held is no reason not to ask.
constexpr std::chrono::milliseconds kPatience{500};

struct Question {
    const char* whether;  // of what nobody can be asked
    const char* text;
    const char* otherwise;  // what has not happened
};

void ask(const std::string& what, const Question& question, bool given, Console& console, StopSignals& signals) {
    if (given) return console.write(what + '\n');
    const std::optional<Terminal> terminal = Terminal::of_process();
    if (!terminal)
        throw SetupError(fmt::format("there is no terminal to ask on whether {}: give --yes for unattended use", question.whether));
    console.set_status({});
    // Let go, a terminal takes what both have to say at once, and one would stand amid the other.
    terminal->wait_while_held(signals);
    (void)console.flush(kPatience);
    const std::string answer = terminal->ask(fmt::format("{}\n{}: ", what, question.text), signals);
    if (signals.token().stop_requested()) throw Stopped(fmt::format("stopped at the question; nothing has {}", question.otherwise));
    if (answer != "yes") throw SetupError(fmt::format("not confirmed; nothing has {}", question.otherwise));
}

}  // namespace

void ask_consent(const std::string& what_will_move, bool given, Console& console, StopSignals& signals, bool has_moved) {
    ask(what_will_move,
        {"the machine may move", "Spindle off, hand on the stop? Type yes to let the machine move", has_moved ? "moved since" : "moved"},
        given, console, signals);
}

void ask_to_change(const std::string& what_will_change, bool given, Console& console, StopSignals& signals) {
    ask(what_will_change, {"the file may be changed", "Type yes to have it changed", "changed"}, given, console, signals);
}

}  // namespace palpate
