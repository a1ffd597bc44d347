// The machine that a session probes with: how it is reached, and what devices/ have to know of it.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "devices/grbl/grbl_controller.h"
#include "devices/modbus/modbus_link.h"
#include "devices/posix/serial_port.h"
#include "devices/posix/tcp_stream.h"
#include "devices/session/machine_settings.h"

namespace palpate {

struct GrblSpec {
    SerialPortOptions port;  // whose path may be "tcp://HOST:PORT"
    Seconds boot_time = grbl::kBootTime;
    std::optional<Seconds> delay{};  // of answers, by what carries them; nothing: as is usual for that

    // Nothing: a serial port.
    [[nodiscard]] std::optional<TcpAddress> address() const { return parse_tcp_address(port.path); }
};

struct ModbusSpec {
    ModbusLinkOptions link;
    std::filesystem::path profile;  // empty: ours
};

// A program of its own: started, or connected to.
struct ExternalSpec {
    std::vector<std::string> command;  // either that ...
    std::string address;               // ... or that, "HOST:PORT"
    Seconds silence{0.5};
    Seconds slowest_answer{2.0};
    Seconds start_time{10.0};
};

using ConnectionSpec = std::variant<GrblSpec, ModbusSpec, ExternalSpec>;
// Their keys below `machine`, in that order.
inline constexpr std::array<std::string_view, std::variant_size_v<ConnectionSpec>> kConnectionKeys = {"grbl", "modbus", "external"};

struct MachineConfig : MachineSettings {
    ConnectionSpec connection;
};

}  // namespace palpate
