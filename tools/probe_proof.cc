#include "tools/probe_proof.h"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <ostream>

namespace palpate {
namespace {

constexpr std::chrono::seconds kPatience{60};
// Between looks: shorter than any hand.
constexpr int kPoll_ms = 40;

// Waits for a look's time. True if a line was entered on a terminal meanwhile.
bool is_line_entered(int in) {
    pollfd waiting{::isatty(in) != 0 ? in : -1, POLLIN, 0};
    if (::poll(&waiting, 1, kPoll_ms) <= 0 || (waiting.revents & POLLIN) == 0) return false;
    std::array<char, 256> line{};
    return ::read(in, line.data(), line.size()) > 0;
}

}  // namespace

bool is_proven_by_hand(ProbeProof proof, bool asks) { return proof == ProbeProof::hand || (proof == ProbeProof::automatic && asks); }

bool see_probe_pressed(Machine& machine, int in, std::ostream& out, const std::stop_token& stop) {
    out << "Press the probe by hand and let it go, so that it is seen to work (Enter: go on without): " << std::flush;
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
    out << (has_closed ? "and did not open again" : "it was not seen to close") << std::endl;
    return false;
}

}  // namespace palpate
