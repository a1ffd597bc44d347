#include "tools/probe_proof.h"

#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <ostream>
#include <thread>

#include "devices/errors.h"

namespace palpate {
namespace {

constexpr std::chrono::seconds kPatience{60};
// Between looks: shorter than any hand.
constexpr int kPoll_ms = 40;

// Waits for a look's time. True if a line was entered on a terminal meanwhile.
bool is_line_entered(int in) {
    pollfd waiting{::isatty(in) != 0 ? in : -1, POLLIN, 0};
    if (::poll(&waiting, 1, kPoll_ms) <= 0) return false;
    if ((waiting.revents & POLLIN) == 0) {
        std::this_thread::sleep_for(std::chrono::milliseconds(kPoll_ms));  // the terminal is gone
        return false;
    }
    std::array<char, 256> line{};
    return ::read(in, line.data(), line.size()) > 0;
}

}  // namespace

bool is_proven_by_hand(ProbeProof proof, bool asks) { return proof == ProbeProof::hand || (proof == ProbeProof::automatic && asks); }

bool see_probe_pressed(Machine& machine, int in, const char* enter, std::ostream& out, const std::stop_token& stop) {
    (void)::tcflush(in, TCIFLUSH);
    out << "Press the probe by hand and let it go, so that it is seen to work";
    if (::isatty(in) != 0) out << " (Enter: " << enter << ")";
    out << ": " << std::flush;
    const auto until = std::chrono::steady_clock::now() + kPatience;
    bool has_closed = false;
    while (std::chrono::steady_clock::now() < until && !stop.stop_requested()) {
        const bool is_closed = machine.is_probe_closed();
        if (is_closed && !has_closed) out << "it closed, " << std::flush;
        has_closed |= is_closed;
        if (has_closed && !is_closed) {
            out << "it opened: it works" << std::endl;
            return true;
        }
        if (is_line_entered(in)) break;
    }
    if (stop.stop_requested()) {
        out << std::endl;
        throw Stopped("stopped while the probe was to be pressed; nothing has moved since");
    }
    out << (has_closed ? "and did not open again" : "it was not seen to close") << std::endl;
    return false;
}

}  // namespace palpate
