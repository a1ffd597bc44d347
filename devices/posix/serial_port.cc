#include "devices/posix/serial_port.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <thread>
#include <vector>

#include "devices/errors.h"

namespace palpate {
namespace {

using namespace std::chrono_literals;

// DTR has to be low that long for a board's reset to notice.
constexpr auto kResetPulse = 50ms;

struct Speed {
    int baud;
    speed_t code;
};
// Those that libmodbus knows, too.
constexpr std::array<Speed, 15> kSpeeds = {{{1200, B1200},
                                            {2400, B2400},
                                            {4800, B4800},
                                            {9600, B9600},
                                            {19200, B19200},
                                            {38400, B38400},
                                            {57600, B57600},
                                            {115200, B115200},
                                            {230400, B230400},
                                            {460800, B460800},
                                            {500000, B500000},
                                            {576000, B576000},
                                            {921600, B921600},
                                            {1000000, B1000000},
                                            {1500000, B1500000}}};

const Speed* find_speed(int baud) {
    const auto* const found = std::ranges::find(kSpeeds, baud, &Speed::baud);
    return found == kSpeeds.end() ? nullptr : found;
}

std::string advice(int error) {
    switch (error) {
        case ENOENT:
        case ENODEV:
        case ENXIO:
            return "no such port; `palpate ports` lists those that there are";
        case EACCES:
        case EPERM:
            return "you may not use it; join its group, often `sudo adduser $USER dialout`, and log in again";
        default:
            return reason(error);
    }
}

}  // namespace

bool is_serial_speed(int baud) { return find_speed(baud) != nullptr; }

std::string serial_speeds() {
    std::vector<int> bauds;
    bauds.reserve(kSpeeds.size());
    for (const Speed& speed : kSpeeds) bauds.push_back(speed.baud);
    return fmt::format("{}", fmt::join(bauds, ", "));
}

SerialPort::SerialPort(const SerialPortOptions& options) : DescriptorStream(options.path) {
    file_ = ::open(options.path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (file_ < 0) throw DeviceError(fmt::format("{}: cannot be opened: {}", name(), advice(errno)));
    lock();
    configure(options);
}

ssize_t SerialPort::put(std::string_view bytes) { return ::write(file_, bytes.data(), bytes.size()); }

void SerialPort::lock() const {
    // TIOCEXCL keeps out other programs, but not those of root; flock keeps out other Palpates, whoever runs them.
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
        throw DeviceError(
            fmt::format("{}: is in use by another process; one machine takes one session at a time: end the other first", name()));
    }
    ::ioctl(file_, TIOCEXCL);
}

void SerialPort::configure(const SerialPortOptions& options) const {
    termios settings{};
    if (::tcgetattr(file_, &settings) != 0) {
        throw DeviceError(fmt::format("{}: is no serial port; `palpate ports` lists those that there are", name()));
    }
    ::cfmakeraw(&settings);
    settings.c_cflag |= CLOCAL | CREAD;
    settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS);
    if (options.reset) {
        settings.c_cflag |= HUPCL;
    } else {
        settings.c_cflag &= ~static_cast<tcflag_t>(HUPCL);
    }
    settings.c_cc[VMIN] = 0;
    settings.c_cc[VTIME] = 0;
    const Speed* const speed = find_speed(options.baud);
    if (speed == nullptr) {
        throw DeviceError(fmt::format("{}: {} baud is no speed of serial ports; allowed: {}", name(), options.baud, serial_speeds()));
    }
    if (::cfsetspeed(&settings, speed->code) != 0 || ::tcsetattr(file_, TCSANOW, &settings) != 0) {
        throw DeviceError(fmt::format("{}: does not take {} baud: {}", name(), options.baud, reason(errno)));
    }
    if (options.reset) {
        // A pseudo-terminal has no such lines, and nothing to reset.
        const int dtr = TIOCM_DTR;
        if (::ioctl(file_, TIOCMBIC, &dtr) == 0) {
            std::this_thread::sleep_for(kResetPulse);
            ::ioctl(file_, TIOCMBIS, &dtr);
        }
    }
    ::tcflush(file_, TCIOFLUSH);
}

std::string SerialPort::lost(const std::string& what) const {
    return fmt::format("{}: the connection is lost ({}): plug it in again, check the machine, then resume", name(), what);
}

}  // namespace palpate
