// The states of a virtual GRBL controller and the ways between them.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "sim/machines/grbl/internal/grbl_block.h"
#include "sim/machines/grbl/internal/grbl_faults.h"
#include "sim/machines/grbl/internal/grbl_output.h"
#include "sim/machines/grbl/internal/grbl_planner.h"
#include "sim/machines/grbl/internal/grbl_report.h"
#include "sim/machines/grbl/internal/grbl_settings.h"
#include "sim/machines/grbl/virtual_grbl.h"

namespace palpate {

// As the firmware, one loop executes lines and stands still where a line has to wait; real-time bytes come between.
class GrblMachine {
public:
    GrblMachine(VirtualTool& tool, const VirtualGrblOptions& options);

    void receive(std::string_view bytes);
    void advance(Seconds time);
    [[nodiscard]] std::string take_output();
    [[nodiscard]] std::string banner() const;
    [[nodiscard]] std::optional<Seconds> time_to_event() const;
    void press_reset();
    [[nodiscard]] VirtualGrbl::Link link() const { return link_; }
    void unplug();
    void plug_in();
    [[nodiscard]] const VirtualGrbl::Counts& counts() const { return counts_; }
    [[nodiscard]] const VirtualTool& tool() const { return tool_; }
    [[nodiscard]] Seconds now() const { return now_; }

private:
    static constexpr Seconds kSameTime{1e-9};  // sums of times are told apart no better

    enum class State { idle, run, hold, jog, home, alarm, check };
    enum class Hearing {
        all,
        later,  // real-time bytes wait until the loop goes on
        none,   // what comes is lost
    };
    // Why the loop stands still, and how it goes on.
    struct Blocked {
        enum class On { time, rest, slot, reset };
        On on = On::time;
        Seconds until{0.0};
        Hearing hearing = Hearing::all;
        bool line = true;       // a line waits for its answer
        bool critical = false;  // a reset that is asked for meanwhile is swallowed
        std::function<void()> then{};
    };

    // grbl_machine.cc: bytes and time
    void boot();
    void run();
    [[nodiscard]] bool is_over(const Blocked& blocked) const;
    void unblock(const Blocked& blocked);
    void wait(Seconds time, Hearing hearing, std::function<void()> then);
    void wait_for_rest(std::function<void()> then);
    void note_rest();
    void handle_realtime(char c);
    void handle_override(unsigned char byte);
    void feed_hold();
    void cycle_start();
    void say(std::string_view line);
    void say_status();
    void answer(int error);

    // grbl_alarms.cc: resets, alarms, faults
    void reset();
    void finish_reset(bool line);
    void alarm(int code, bool line, std::function<void()> then);
    void raise_alarm(int code, bool line);
    void handle_due_faults();
    void apply(const VirtualFault& fault);
    [[nodiscard]] std::optional<int> suffer(VirtualFault::When when, double at);

    // grbl_lines.cc: what lines do
    void execute(const GrblLine& line);
    void execute_system(std::string_view line);
    [[nodiscard]] int execute_report(std::string_view line);
    [[nodiscard]] int execute_setting(std::string_view line);
    void toggle_check_mode();
    void unlock();
    void home();
    void jog(std::string_view line);
    void execute_code(std::string_view line);
    void execute_motion(const GrblBlock& block);
    void begin_probe(const GrblBlock& block);
    void finish_probe(int motion);
    [[nodiscard]] bool is_beyond_limits(const Point& target) const;
    [[nodiscard]] Point reported_position() const;

    VirtualTool& tool_;
    VirtualGrblOptions options_;
    GrblSettings settings_;
    GrblStatusReport status_;
    GrblFaults faults_;
    GrblPlanner planner_;
    GrblOutput output_;
    VirtualGrbl::Link link_ = VirtualGrbl::Link::up;
    VirtualGrbl::Counts counts_;
    Seconds now_{0.0};

    State state_ = State::idle;
    std::optional<Blocked> blocked_;
    std::deque<char> buffer_;
    GrblLine line_;
    GrblModal modal_;
    GrblFrame frame_;
    GrblProbeRecord probe_;
    bool has_probed_ = false;
    int sticky_error_ = 0;        // grblHAL only
    bool critical_ = false;       // grblHAL: only a reset ends this alarm
    bool critical_line_ = false;  // the line that ran into it is answered only then
    bool homed_ = false;
    bool probe_cut_ = false;
    std::uint64_t contacts_ = 0;
    Vector probe_direction_ = Vector::Zero();  // of the last G38 move
    double probe_feed_mm_per_s_ = 0.0;
    std::optional<VirtualFault> position_fault_;
    Vector position_shift_ = Vector::Zero();
    Point frozen_position_ = Point::Zero();
    Seconds latch_delay_{0.0};
    GrblOverrides overrides_;
    bool silent_ = false;
    bool reset_asked_ = false;  // while real-time bytes wait
    bool status_asked_ = false;
    char last_byte_ = '\0';
    std::optional<double> spurious_share_;  // of the time of the next probe move
    std::optional<Seconds> spurious_at_;
};

}  // namespace palpate
