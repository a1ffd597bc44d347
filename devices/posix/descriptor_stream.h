// What the streams on a file descriptor of the system share: reading and writing that wait for a limited time.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <string>
#include <string_view>
#include <utility>

#include "devices/byte_stream.h"

namespace palpate {

class DescriptorStream : public ByteStream {
public:
    ~DescriptorStream() override;
    DescriptorStream(const DescriptorStream&) = delete;
    DescriptorStream& operator=(const DescriptorStream&) = delete;
    DescriptorStream(DescriptorStream&&) = delete;
    DescriptorStream& operator=(DescriptorStream&&) = delete;

    [[nodiscard]] std::string read(std::chrono::milliseconds timeout) final;
    void write(std::string_view bytes) final;
    [[nodiscard]] std::string name() const final { return name_; }

protected:
    // What is opened later is put into `file_`, not to block; it is closed here.
    explicit DescriptorStream(std::string name) : name_(std::move(name)) {}

    int file_ = -1;

private:
    // As ::write.
    [[nodiscard]] virtual ssize_t put(std::string_view bytes) = 0;
    // Says why and what to do.
    [[nodiscard]] virtual std::string lost(const std::string& what) const = 0;
    [[nodiscard]] virtual const char* end_of_file() const = 0;

    const std::string name_;
};

}  // namespace palpate
