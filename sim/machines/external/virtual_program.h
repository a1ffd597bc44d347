// A program that drives a virtual machine and speaks as devices/external/PROTOCOL.md has it, on a port of this computer's own network, in
// a thread of its own.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "sim/machines/tcp_client_end.h"
#include "sim/machines/virtual_tool.h"

namespace palpate {

// What it does wrong, once: in the `at`-th move, counted from 1.
struct ProgramFault {
    enum class Kind : std::uint8_t {
        silent,           // says nothing more, from the middle of the move on, though the move goes on
        hang_up,          // the connection ends in the middle of the move
        wrong_id,         // answers another question
        no_json,          // says something else first
        touched_beside,   // tells a touch beside the way
        rest_beside,      // tells a place of rest beside the way
        rest_far,         // tells that it rests far beyond the touch
        seen_beside,      // a sign of life tells a place beside the way
        refuses,          // answers with an error; nothing moves
        stops_by_itself,  // ends the move as stopped, though nobody asked
        half_answer,      // the answer lacks its position
        never_ends,       // signs of life, but no end
        stays_closed,     // the probe reads as closed from then on
        error_in_move,    // says an error in the middle of the move, as a library that throws
        closed_at_end,    // the probe closes as the move ends, which it did not end
    };
    Kind kind = Kind::silent;
    std::uint64_t at = 1;
};

struct VirtualProgramOptions {
    int port = 0;         // of 127.0.0.1; 0: any that is free
    bool is_fast = true;  // motion takes no time
    std::string name = "Virtual arm 1.0";
    bool homed = true;
    bool homes = false;   // it can be asked to
    std::string fault{};  // in words; it does not move then
    bool stops_at_touch = true;
    bool latches = true;
    Seconds latch_time{0};
    std::vector<ProgramFault> faults{};
};

class VirtualProgram {
public:
    // `tool` must outlive it; until then, reach it through with() only. Throws ConnectionLost if the port is taken.
    VirtualProgram(VirtualTool& tool, VirtualProgramOptions options);
    ~VirtualProgram();
    VirtualProgram(const VirtualProgram&) = delete;
    VirtualProgram& operator=(const VirtualProgram&) = delete;
    VirtualProgram(VirtualProgram&&) = delete;
    VirtualProgram& operator=(VirtualProgram&&) = delete;

    // "127.0.0.1:PORT"
    [[nodiscard]] std::string address() const;
    // The machine stands still meanwhile.
    void with(const std::function<void(VirtualTool&)>& use);
    [[nodiscard]] std::uint64_t moves() const;
    // Moves that it stopped because its host was gone or silent.
    [[nodiscard]] std::uint64_t abandoned() const;

private:
    struct Move;
    void serve(const std::stop_token& stop);
    void hear(const std::string& line);
    void begin(std::uint64_t id, const Point& to, double feed_mm_per_s, bool until_open);
    void end_move();
    void say(const std::string& line) { to_send_ += line + '\n'; }
    void advance(Seconds time);
    void leave();
    [[nodiscard]] bool suffers(ProgramFault::Kind kind) const;
    [[nodiscard]] bool is_probe_closed() const;

    VirtualTool& tool_;
    const VirtualProgramOptions options_;
    TcpClientEnd end_;
    mutable std::mutex mutex_;  // over what follows
    bool is_homed_;
    std::string heard_;
    std::string to_send_;
    std::unique_ptr<Move> move_;
    std::uint64_t moves_ = 0;
    std::uint64_t abandoned_ = 0;
    bool is_mute_ = false;
    bool is_stuck_ = false;
    bool is_pressed_ = false;
    double silence_s_ = 0.5;
    std::jthread thread_;  // last: it uses all of the above
};

}  // namespace palpate
