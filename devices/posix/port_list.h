// Which serial ports this computer has, and what hangs on them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace palpate {

struct PortInfo {
    std::string path;          // "/dev/ttyUSB0"
    std::string usb_id;        // "2341:0043", vendor and product; empty: not on USB
    std::string manufacturer;  // as the device says
    std::string product;
    std::string serial;
    std::string driver;  // "ch341-uart"

    friend bool operator==(const PortInfo&, const PortInfo&) = default;
};

// By path. A port without hardware behind it, as ttyS4 to ttyS31 are on most computers, is left out. `sysfs` is where the kernel
// describes its devices. Throws nothing; what cannot be read is empty.
[[nodiscard]] std::vector<PortInfo> list_ports(const std::filesystem::path& sysfs = "/sys");

}  // namespace palpate
