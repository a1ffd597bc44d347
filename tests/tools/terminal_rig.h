// A pseudo-terminal with a running program in it, and somebody who types.
#pragma once

#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace palpate {

class TypedAt {
public:
    static constexpr const char* kCtrlC = "\x03";
    static constexpr const char* kCtrlBackslash = "\x1c";
    static constexpr const char* kCtrlZ = "\x1a";
    static constexpr const char* kCtrlS = "\x13";
    static constexpr const char* kCtrlQ = "\x11";

    // Runs palpate with these words, or another program if the first is a path.
    TypedAt(const std::filesystem::path& folder, std::vector<std::string> words, unsigned short columns = 80) {
        if (!words.front().starts_with('/')) words.insert(words.begin(), PALPATE_EXECUTABLE);
        std::vector<char*> argv;
        for (std::string& word : words) argv.push_back(word.data());
        argv.push_back(nullptr);
        const winsize size{24, columns, 0, 0};
        shell_ = forkpty(&master_, nullptr, nullptr, &size);
        if (shell_ == 0) be_shell(folder.c_str(), argv.data());
        for (int k = 0; k < 5000 && (id() <= 0 || id() == shell_) && !is_over(); ++k) usleep(1000);
    }
    ~TypedAt() {
        close(master_);
        if (has_ended_) return;
        kill(shell_, SIGKILL);
        waitpid(shell_, nullptr, 0);
    }
    TypedAt(const TypedAt&) = delete;
    TypedAt& operator=(const TypedAt&) = delete;
    TypedAt(TypedAt&&) = delete;
    TypedAt& operator=(TypedAt&&) = delete;

    // Of the program, which is the job in the foreground; none (0, or less) before it begins and when it has ended.
    [[nodiscard]] pid_t id() const { return tcgetpgrp(master_); }
    void type(const std::string& text) const { ASSERT_EQ(write(master_, text.data(), text.size()), static_cast<ssize_t>(text.size())); }
    void send(int signal) const {
        // kill() takes 0 for our own group, and -1 for whatever runs.
        if (const pid_t program = id(); program > 0) kill(program, signal);
    }
    // Reads on until it has said that; false if it ended before, or did not within 20 s.
    bool wait_for(const std::string& text) {
        const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
        while (said.find(text) == std::string::npos) {
            if (std::chrono::steady_clock::now() > until || !read_some(20'000)) return false;
        }
        return true;
    }
    // Reads what comes meanwhile.
    void watch(std::chrono::milliseconds time) {
        const auto until = std::chrono::steady_clock::now() + time;
        while (std::chrono::steady_clock::now() < until) (void)read_some(10);
    }
    // Exit code; 128 and the signal if one ended it.
    int wait() {
        while (read_some(20'000)) {
        }
        return ended();
    }
    // The same of a program that nobody reads any more.
    int ended() {
        int status = 0;
        waitpid(shell_, &status, 0);
        has_ended_ = true;
        return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
    // Whether it has stopped, as a shell sees it, within that time.
    [[nodiscard]] bool stops(std::chrono::milliseconds time) {
        const auto until = std::chrono::steady_clock::now() + time;
        while (std::chrono::steady_clock::now() < until) {
            std::ifstream stat("/proc/" + std::to_string(id()) + "/stat");
            std::string line;
            std::getline(stat, line);
            if (const std::size_t name = line.rfind(')'); name != std::string::npos && line.compare(name, 3, ") T") == 0) return true;
            (void)read_some(10);
        }
        return false;
    }

    std::string said;

private:
    // The shell has ended, and was not waited for.
    [[nodiscard]] bool is_over() const {
        siginfo_t info{};
        return waitid(P_PID, static_cast<id_t>(shell_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid != 0;
    }
    bool read_some(int patience_ms) {
        pollfd waiting{master_, POLLIN, 0};
        if (poll(&waiting, 1, patience_ms) <= 0) return false;
        std::array<char, 4096> bytes{};
        const ssize_t count = read(master_, bytes.data(), bytes.size());
        if (count > 0) said.append(bytes.data(), static_cast<std::size_t>(count));
        return count > 0;
    }

    // What a shell does for a job: without one above, Ctrl-Z stops nothing. Only what may be called between fork and exec.
    [[noreturn]] static void be_shell(const char* folder, char* const* argv) {
        const pid_t job = fork();
        if (job == 0) {
            setpgid(0, 0);
            signal(SIGTTOU, SIG_IGN);
            tcsetpgrp(STDIN_FILENO, getpid());
            signal(SIGTTOU, SIG_DFL);
            if (chdir(folder) == 0) execv(argv[0], argv);
            _exit(127);
        }
        int status = 0;
        waitpid(job, &status, 0);
        _exit(WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status));
    }

    int master_ = -1;
    pid_t shell_ = 0;
    bool has_ended_ = false;
};

}  // namespace palpate
