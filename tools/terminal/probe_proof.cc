#include "tools/terminal/probe_proof.h"

#include <fmt/format.h>

#include <chrono>
#include <optional>
#include <string>
#include <thread>

#include "devices/errors.h"
#include "tools/terminal/terminal.h"

namespace palpate {
namespace {

constexpr std::chrono::seconds kPressWithin{60};
// Between looks: shorter than any hand.
constexpr std::chrono::milliseconds kLook{40};

}  // namespace

bool is_proven_by_hand(ProbeProof proof, bool asks) { return proof == ProbeProof::hand || (proof == ProbeProof::automatic && asks); }

bool see_probe_pressed(Machine& machine, const char* enter, Console& console, StopSignals& signals) {
    const std::optional<Terminal> terminal = Terminal::of_process();
    const auto say = [&](const std::string& text) { terminal ? terminal->say(text, signals) : console.write(text); };
    const std::string question = fmt::format("Press the probe by hand and let it go, so that it is seen to work{}: ",
                                             terminal ? fmt::format(" (Enter: {})", enter) : std::string());
    terminal ? terminal->pose(question, signals) : console.write(question);
    const auto until = std::chrono::steady_clock::now() + kPressWithin;
    bool has_closed = false;
    while (std::chrono::steady_clock::now() < until && !signals.token().stop_requested()) {
        signals.pause();
        const bool is_closed = machine.is_probe_closed();
        if (is_closed && !has_closed) say("it closed, ");
        has_closed |= is_closed;
        if (has_closed && !is_closed) {
            say("it opened: it works\n");
            return true;
        }
        if (terminal && terminal->is_line_entered(kLook)) break;
        if (!terminal) std::this_thread::sleep_for(kLook);
    }
    if (signals.token().stop_requested()) {
        say("\n");
        throw Stopped("stopped while the probe was to be pressed; nothing has moved since");
    }
    say(has_closed ? "and did not open again\n" : "it was not seen to close\n");
    return false;
}

}  // namespace palpate
