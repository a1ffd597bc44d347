// The seam between a serial protocol and what carries its bytes: a port, or a virtual machine in the same process.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

namespace palpate {

// Both ways, in order, unframed. Every call throws ConnectionLost (devices/errors.h) once the other side is gone.
class ByteStream {
public:
    virtual ~ByteStream() = default;

    // What has come, waiting at most `timeout` for the first byte; empty if none came.
    [[nodiscard]] virtual std::string read(std::chrono::milliseconds timeout) = 0;
    // All of it, or throws.
    virtual void write(std::string_view bytes) = 0;
    // What it is called in messages, such as "/dev/ttyUSB0".
    [[nodiscard]] virtual std::string name() const = 0;
};

}  // namespace palpate
