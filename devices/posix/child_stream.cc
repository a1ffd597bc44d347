#include "devices/posix/child_stream.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <thread>

#include "devices/errors.h"

namespace palpate {
namespace {

using namespace std::chrono_literals;

// A program that drives a machine stops it, and may have to say farewell to it, before it ends.
constexpr auto kGrace = 3000ms;
// A program that ended has been so for that long when its output is seen to end.
constexpr auto kEnding = 200ms;
constexpr auto kPause = 5ms;

// Whether it has ended by then, and how.
bool has_ended(pid_t child, std::chrono::milliseconds patience, int& status) {
    const auto until = std::chrono::steady_clock::now() + patience;
    while (true) {
        const pid_t ended = ::waitpid(child, &status, WNOHANG);
        if (ended == child || (ended < 0 && errno != EINTR)) return true;
        if (std::chrono::steady_clock::now() >= until) return false;
        std::this_thread::sleep_for(kPause);
    }
}

}  // namespace

ChildStream::ChildStream(const std::vector<std::string>& command)
    : DescriptorStream(command.front()), lock_(MachineLock::of_name(fmt::format("{}", fmt::join(command, " ")))) {
    // One socket for both ways: what goes to a program that has ended is an error then, and no signal.
    std::array<int, 2> ends{-1, -1};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
        throw DeviceError(fmt::format("{}: cannot be started: {}", name(), reason(errno)));
    }
    file_ = ends[0];
    ::fcntl(file_, F_SETFL, O_NONBLOCK);
    posix_spawn_file_actions_t files{};
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, ends[1], STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&files, ends[1], STDOUT_FILENO);
    posix_spawnattr_t attributes{};
    posix_spawnattr_init(&attributes);
    // What is ignored or blocked here is not there.
    sigset_t none{};
    sigset_t all{};
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &all);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    std::vector<std::string> words = command;
    std::vector<char*> argv;
    argv.reserve(words.size() + 1);
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    const int error = ::posix_spawnp(&child_, argv.front(), &files, &attributes, argv.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
    ::close(ends[1]);
    if (error != 0) {
        child_ = -1;
        throw DeviceError(
            fmt::format("{}: cannot be started: {}: is machine.external.command right, may the file be run?", name(), reason(error)));
    }
}

ChildStream::~ChildStream() {
    if (child_ < 0) return;
    ::shutdown(file_, SHUT_WR);
    int status = 0;
    if (!has_ended(child_, kGrace, status)) {
        ::kill(-child_, SIGKILL);
        ::waitpid(child_, &status, 0);
    }
    // What a launcher has left behind.
    ::kill(-child_, SIGKILL);
}

ssize_t ChildStream::put(std::string_view bytes) { return ::send(file_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }

std::string ChildStream::lost(const std::string& what) const {
    siginfo_t info{};
    const auto until = std::chrono::steady_clock::now() + kEnding;
    // Looks without taking: the destructor does.
    do {
        ::waitid(P_PID, static_cast<id_t>(child_), &info, WEXITED | WNOHANG | WNOWAIT);
        if (info.si_pid == 0) std::this_thread::sleep_for(kPause);
    } while (info.si_pid == 0 && std::chrono::steady_clock::now() < until);
    const std::string how = info.si_pid == 0             ? what
                            : info.si_code == CLD_EXITED ? fmt::format("it ended with exit code {}", info.si_status)
                                                         : fmt::format("it was ended by signal {}", info.si_status);
    return fmt::format("{}: the program that drives the machine is gone ({}): see where the tool is and what the program said, then resume",
                       name(), how);
}

}  // namespace palpate
