// Keeps a second process away from a controller. The kernel lets go when the holder ends, however it ends.
#pragma once

#include <string>

namespace palpate {

class MachineLock {
public:
    // On a serial device: flock. Throws ConnectionLost if it cannot be opened, DeviceError if another process holds it.
    [[nodiscard]] static MachineLock of_device(const std::string& path);
    // On a peer that has no file: a unix socket with an abstract name. Throws DeviceError if another process holds it.
    [[nodiscard]] static MachineLock of_peer(const std::string& numeric_host, int port);

    // The same for what has neither, by a name of any length.
    [[nodiscard]] static MachineLock of_name(const std::string& machine);

    MachineLock() = default;
    ~MachineLock();
    MachineLock(MachineLock&& other) noexcept;
    MachineLock& operator=(MachineLock&& other) noexcept;
    MachineLock(const MachineLock&) = delete;
    MachineLock& operator=(const MachineLock&) = delete;

private:
    explicit MachineLock(int descriptor) : descriptor_(descriptor) {}
    int descriptor_ = -1;
};

}  // namespace palpate
