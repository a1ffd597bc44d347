// A program that is started here, as a ByteStream: what is written goes to its standard input, what is read is its standard output.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "devices/posix/descriptor_stream.h"
#include "devices/posix/machine_lock.h"

namespace palpate {

class ChildStream final : public DescriptorStream {
public:
    // `command`: the program, looked for in PATH, and its arguments; not empty. Its standard error stays ours. It is in a process group of
    // its own, so that Ctrl-C at our terminal does not end it: it is ours to end, when what it moves stands.
    // Throws DeviceError if it cannot be started, or another process of this computer runs that command in this way.
    explicit ChildStream(const std::vector<std::string>& command);
    // Ends its input, by which it ends; one that does not is killed.
    ~ChildStream() override;
    ChildStream(const ChildStream&) = delete;
    ChildStream& operator=(const ChildStream&) = delete;
    ChildStream(ChildStream&&) = delete;
    ChildStream& operator=(ChildStream&&) = delete;

private:
    [[nodiscard]] ssize_t put(std::string_view bytes) override;
    [[nodiscard]] std::string lost(const std::string& what) const override;
    [[nodiscard]] const char* end_of_file() const override { return "it ended its output"; }

    MachineLock lock_;
    pid_t child_ = -1;
};

}  // namespace palpate
