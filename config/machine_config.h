// The machine that a session probes with: how it is reached, and what devices/ have to know of it.
#pragma once

#include <array>
#include <filesystem>
#include <string_view>
#include <variant>

#include "devices/modbus/modbus_link.h"
#include "devices/posix/serial_port.h"
#include "devices/session/machine_settings.h"

namespace palpate {

struct GrblSpec {
    SerialPortOptions port;
};

struct ModbusSpec {
    ModbusLinkOptions link;
    std::filesystem::path profile;  // empty: ours
};

using ConnectionSpec = std::variant<GrblSpec, ModbusSpec>;
// Their keys below `machine`, in that order.
inline constexpr std::array<std::string_view, std::variant_size_v<ConnectionSpec>> kConnectionKeys = {"grbl", "modbus"};

struct MachineConfig : MachineSettings {
    ConnectionSpec connection;
};

}  // namespace palpate
