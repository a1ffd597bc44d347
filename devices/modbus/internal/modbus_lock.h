// Keeps a second process away from a controller. The kernel lets go when the holder ends, however it ends.
#pragma once

#include <string>

namespace palpate {

class ModbusLock {
public:
    // On a serial device: flock. Throws ConnectionLost if it cannot be opened, DeviceError if another process holds it.
    [[nodiscard]] static ModbusLock of_device(const std::string& path);
    // On a peer that has no file: a unix socket with an abstract name. Throws DeviceError if another process holds it.
    [[nodiscard]] static ModbusLock of_peer(const std::string& numeric_host, int port);

    ModbusLock() = default;
    ~ModbusLock();
    ModbusLock(ModbusLock&& other) noexcept;
    ModbusLock& operator=(ModbusLock&& other) noexcept;
    ModbusLock(const ModbusLock&) = delete;
    ModbusLock& operator=(const ModbusLock&) = delete;

private:
    explicit ModbusLock(int descriptor) : descriptor_(descriptor) {}
    int descriptor_ = -1;
};

}  // namespace palpate
