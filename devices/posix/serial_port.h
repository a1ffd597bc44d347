// A serial port as a ByteStream: POSIX termios, raw, eight data bits, no parity, one stop bit. One process at a time.
#pragma once

#include <string>
#include <string_view>

#include "devices/posix/descriptor_stream.h"

namespace palpate {

struct SerialPortOptions {
    std::string path;  // "/dev/ttyUSB0", or a link to it
    int baud = 115200;
    // Opening a USB port resets many boards, which frees their motors. true: the board is reset for certain (DTR falls and rises); false:
    // it is spared where the port allows that (DTR stays high after closing).
    bool reset = false;
};

// The speeds that ports are opened with: "9600, 19200, …", for messages.
[[nodiscard]] bool is_serial_speed(int baud);
[[nodiscard]] std::string serial_speeds();

class SerialPort final : public DescriptorStream {
public:
    // Throws DeviceError, which names the port and what to do: it is not there, may not be used, is in use, is no serial port, or
    // does not know that speed.
    explicit SerialPort(const SerialPortOptions& options);

private:
    [[nodiscard]] ssize_t put(std::string_view bytes) override;
    [[nodiscard]] std::string lost(const std::string& what) const override;
    [[nodiscard]] const char* end_of_file() const override { return "end of file"; }

    void lock() const;
    void configure(const SerialPortOptions& options) const;
};

}  // namespace palpate
