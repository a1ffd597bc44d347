#include "devices/posix/port_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <system_error>

namespace palpate {
namespace {

namespace fs = std::filesystem;

std::string first_line(const fs::path& file) {
    std::ifstream in(file);
    std::string line;
    std::getline(in, line);
    return line;
}

// The kernel numbers the ports of a UART that is not there as well, with type 0 (PORT_UNKNOWN).
bool has_hardware(const fs::path& port) {
    const std::string type = first_line(port / "type");
    return type.empty() || type != "0";
}

PortInfo describe(const fs::path& port) {
    PortInfo info;
    info.path = "/dev/" + port.filename().string();
    std::error_code error;
    const fs::path device = fs::canonical(port / "device", error);
    if (error) return info;
    const fs::path driver = fs::canonical(port / "device" / "driver", error);
    if (!error) info.driver = driver.filename().string();
    // The USB device is a few folders above its interface.
    for (fs::path folder = device; folder.has_relative_path(); folder = folder.parent_path()) {
        if (!fs::exists(folder / "idVendor", error)) continue;
        info.usb_id = fmt::format("{}:{}", first_line(folder / "idVendor"), first_line(folder / "idProduct"));
        info.manufacturer = first_line(folder / "manufacturer");
        info.product = first_line(folder / "product");
        info.serial = first_line(folder / "serial");
        break;
    }
    return info;
}

}  // namespace

std::vector<PortInfo> list_ports(const fs::path& sysfs) {
    std::vector<PortInfo> ports;
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(sysfs / "class" / "tty", error)) {
        std::error_code ignored;  // virtual consoles and pseudo-terminals have no device
        if (!fs::exists(entry.path() / "device", ignored) || !has_hardware(entry.path())) continue;
        ports.push_back(describe(entry.path()));
    }
    std::sort(ports.begin(), ports.end(), [](const PortInfo& a, const PortInfo& b) { return a.path < b.path; });
    return ports;
}

}  // namespace palpate
