// The far end of a serial port that exists only in this computer: what a virtual machine reads and writes.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace palpate {

// Raw: no echo, no line editing. Nothing here waits. Closing it hangs up: the client sees the end of the file, or EIO.
class PseudoTerminal {
public:
    // `link`, if not empty, becomes a symbolic link to the client's end and is removed at the end; one that is there is replaced.
    // Throws ConnectionLost (devices/errors.h) if the system has no pseudo-terminal to give, or `link` is something else than a link.
    explicit PseudoTerminal(std::filesystem::path link = {});
    ~PseudoTerminal();
    PseudoTerminal(const PseudoTerminal&) = delete;
    PseudoTerminal& operator=(const PseudoTerminal&) = delete;

    [[nodiscard]] const std::string& client_path() const { return client_path_; }
    // For poll: bytes may have come, or the client has gone; somebody has opened the client's end.
    [[nodiscard]] int descriptor() const { return descriptor_; }
    [[nodiscard]] int openings_descriptor() const { return openings_; }

    // False until a client opens its end, and after the last one has closed it.
    [[nodiscard]] bool has_client() const;
    // Has somebody opened it since this was asked last? What a client writes is never read before its opening can be seen here.
    [[nodiscard]] bool take_openings();
    // What has come. Empty if that is nothing, or nobody is there.
    [[nodiscard]] std::string read();
    // How many of the bytes were taken: fewer if the client does not read, none if nobody is there.
    [[nodiscard]] std::size_t write(std::string_view bytes);

private:
    void make_client_raw();
    void make_link();

    int descriptor_ = -1;
    int openings_ = -1;  // of inotify
    std::string client_path_;
    std::filesystem::path link_;
};

}  // namespace palpate
