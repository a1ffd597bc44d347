// The far end of a serial port that exists only in this computer: what a virtual machine reads and writes.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "sim/machines/client_end.h"

namespace palpate {

// Raw: no echo, no line editing. Nothing here waits. Closing it hangs up: the client sees the end of the file, or EIO.
class PseudoTerminal final : public ClientEnd {
public:
    // `link`, if not empty, becomes a symbolic link to the client's end and is removed at the end; one that is there is replaced.
    // Throws ConnectionLost (devices/errors.h) if the system has no pseudo-terminal to give, or `link` is something else than a link.
    explicit PseudoTerminal(std::filesystem::path link = {});
    ~PseudoTerminal() override;
    PseudoTerminal(const PseudoTerminal&) = delete;
    PseudoTerminal& operator=(const PseudoTerminal&) = delete;
    PseudoTerminal(PseudoTerminal&&) = delete;
    PseudoTerminal& operator=(PseudoTerminal&&) = delete;

    [[nodiscard]] std::string client_path() const override { return client_path_; }
    [[nodiscard]] int descriptor() const override { return descriptor_; }
    [[nodiscard]] int openings_descriptor() const override { return openings_; }
    [[nodiscard]] bool has_client() const override;
    [[nodiscard]] bool take_openings() override;
    [[nodiscard]] std::string read() override;
    [[nodiscard]] std::size_t write(std::string_view bytes) override;

private:
    void make_client_raw();
    void make_link();

    int descriptor_ = -1;
    int openings_ = -1;  // of inotify
    std::string client_path_;
    std::filesystem::path link_;
};

}  // namespace palpate
