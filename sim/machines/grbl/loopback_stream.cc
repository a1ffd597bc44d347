#include "sim/machines/grbl/loopback_stream.h"

#include <fmt/format.h>

#include <algorithm>

#include "devices/errors.h"

namespace palpate {

void LoopbackStream::check_link() const {
    if (grbl_.link() == VirtualGrbl::Link::up) return;
    const bool hung_up = grbl_.link() == VirtualGrbl::Link::hung_up;
    throw ConnectionLost(fmt::format("{}: {}; plug the machine in again and reconnect", name(),
                                     hung_up ? "the other side closed the connection" : "input/output error"));
}

std::string LoopbackStream::read(std::chrono::milliseconds timeout) {
    check_link();
    const Seconds end = grbl_.now() + timeout;
    grbl_.advance(kCallTime);
    std::string bytes = grbl_.take_output();
    while (bytes.empty() && grbl_.now() < end) {
        check_link();
        const Seconds left = end - grbl_.now();
        // Never less than a call takes: an event that is due now is over then.
        const Seconds next = std::max(grbl_.time_to_event().value_or(left), kCallTime);
        grbl_.advance(std::min(left, next));
        bytes = grbl_.take_output();
    }
    if (bytes.empty()) check_link();
    return bytes;
}

void LoopbackStream::write(std::string_view bytes) {
    check_link();
    grbl_.advance(kCallTime);
    for (const char& c : bytes) {
        grbl_.advance(kByteTime);
        check_link();
        grbl_.receive({&c, 1});
    }
}

std::chrono::nanoseconds LoopbackStream::now() const { return std::chrono::duration_cast<std::chrono::nanoseconds>(grbl_.now()); }

}  // namespace palpate
