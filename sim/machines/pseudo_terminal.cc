#include "sim/machines/pseudo_terminal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/inotify.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <system_error>
#include <utility>

#include "devices/errors.h"

namespace palpate {
namespace {

[[noreturn]] void give_up(const std::string& what) {
    throw ConnectionLost(fmt::format("pseudo-terminal: {}: {}", what, std::system_category().message(errno)));
}

}  // namespace

PseudoTerminal::PseudoTerminal(std::filesystem::path link)
    : descriptor_(posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)), link_(std::move(link)) {
    if (descriptor_ < 0) give_up("cannot open one; the system may have too many of them");
    try {
        std::array<char, 128> name{};
        if (grantpt(descriptor_) != 0 || unlockpt(descriptor_) != 0 || ptsname_r(descriptor_, name.data(), name.size()) != 0) {
            give_up("cannot prepare the client's end");
        }
        client_path_ = name.data();
        make_client_raw();
        openings_ = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
        if (openings_ < 0 || inotify_add_watch(openings_, client_path_.c_str(), IN_OPEN) < 0) {
            give_up(fmt::format("cannot watch {}", client_path_));
        }
        make_link();
    } catch (...) {
        close(descriptor_);
        if (openings_ >= 0) close(openings_);
        throw;
    }
}

// Opened and closed once: from now on the system tells whether a client is there.
void PseudoTerminal::make_client_raw() {
    const int client = open(client_path_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (client < 0) give_up(fmt::format("cannot open the client's end {}", client_path_));
    termios settings{};
    const bool known = tcgetattr(client, &settings) == 0;
    cfmakeraw(&settings);
    const bool raw = known && tcsetattr(client, TCSANOW, &settings) == 0;
    close(client);
    if (!raw) give_up(fmt::format("cannot make {} raw", client_path_));
}

PseudoTerminal::~PseudoTerminal() {
    close(descriptor_);
    close(openings_);
    std::error_code gone;  // somebody may have replaced or removed it, and may do so now
    if (!link_.empty() && std::filesystem::read_symlink(link_, gone) == client_path_) std::filesystem::remove(link_, gone);
}

void PseudoTerminal::make_link() {
    if (link_.empty()) return;
    std::error_code error;
    const auto there = std::filesystem::symlink_status(link_, error);
    if (std::filesystem::exists(there) && !std::filesystem::is_symlink(there)) {
        throw ConnectionLost(
            fmt::format("pseudo-terminal: {} is there and is not a link; choose another name for the link", link_.string()));
    }
    std::filesystem::remove(link_, error);
    std::filesystem::create_symlink(client_path_, link_, error);
    if (error) {
        throw ConnectionLost(fmt::format("pseudo-terminal: cannot make the link {}: {}; choose a folder that can be written to",
                                         link_.string(), error.message()));
    }
}

bool PseudoTerminal::has_client() const {
    pollfd state{descriptor_, POLLIN, 0};
    return poll(&state, 1, 0) >= 0 && (state.revents & POLLHUP) == 0;
}

bool PseudoTerminal::take_openings() {
    bool opened = false;
    std::array<char, 1024> events{};  // what they say is known
    while (::read(openings_, events.data(), events.size()) > 0) opened = true;
    return opened;
}

std::string PseudoTerminal::read() {
    std::string bytes;
    std::array<char, 1024> part{};
    while (true) {
        const ssize_t count = ::read(descriptor_, part.data(), part.size());
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return bytes;  // EAGAIN: nothing more; EIO: no client
        bytes.append(part.data(), static_cast<std::size_t>(count));
    }
}

std::size_t PseudoTerminal::write(std::string_view bytes) {
    std::size_t done = 0;
    while (done < bytes.size() && has_client()) {
        const ssize_t count = ::write(descriptor_, bytes.data() + done, bytes.size() - done);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) break;
        done += static_cast<std::size_t>(count);
    }
    return done;
}

}  // namespace palpate
