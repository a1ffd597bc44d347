// The ProbeDevice on a machine that a program of its own drives (devices/external/PROTOCOL.md).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "devices/byte_stream.h"
#include "devices/clock.h"
#include "devices/homing.h"
#include "devices/motion_model.h"
#include "devices/probe_device.h"
#include "devices/stop_request.h"
#include "planner/region.h"

namespace palpate {

namespace external {
class Talk;
struct Line;
}  // namespace external
struct Way;

struct ExternalOptions {
    MotionModel motion;
    Point origin = Point::Zero();  // mm, machine coordinates: where Palpate's coordinates have their origin
    Seconds silence{0.5};          // in a move: a program that is silent for so long is dead, and so are we for it
    Seconds slowest_answer{2.0};   // that waits for no motion
    Seconds start_time{10.0};      // from its start to its answer to `hello`
    Homing homing = Homing::require;
    double touch_error_mm = 0.0;    // that the session states
    Pace touch_pace = Pace::probe;  // of the touches that count
};

// What the program says of its machine. Positions and limits are machine coordinates in mm.
struct ExternalHello {
    std::string name;
    Box limits;
    double feed_mm_per_s = 0.0;
    double acceleration_mm_per_s2 = 0.0;
    double resolution_mm = 0.0;
    Seconds latch_time{0};  // from the probe's change until its place is taken, at the most
    bool homes = false;     // when it is asked to
};

struct ExternalState {
    Point position = Point::Zero();  // mm, machine coordinates
    bool is_moving = false;
    bool is_probe_closed = false;
    bool is_homed = false;
    std::string fault;  // empty: none
};

// Positions are Palpate's: the machine's less the origin. An answer counts only if it lies on the way that was told and agrees with where
// the machine then is. After anything else nothing more is sent but a stop, and the device is lost.
class ExternalDevice final : public ProbeDevice {
public:
    // Greets the program and moves nothing. `stream` and `clock` must outlive the device. Throws DeviceError if the program cannot do what
    // is needed, and what guarded_move throws.
    ExternalDevice(ByteStream& stream, Clock& clock, const ExternalOptions& options, StopToken stop = {});
    ~ExternalDevice() override;
    ExternalDevice(const ExternalDevice&) = delete;
    ExternalDevice& operator=(const ExternalDevice&) = delete;
    ExternalDevice(ExternalDevice&&) = delete;
    ExternalDevice& operator=(ExternalDevice&&) = delete;

    [[nodiscard]] Point position() const override { return position_ - options_.origin; }
    // Asks how the machine is before it moves it. Throws ConnectionLost, DeviceTimeout, DeviceRefused, BadAnswer, ProbeClosed, OutOfLimits,
    // DeviceAlarm (a fault of the machine, or somebody else moves it), and Stopped, after the tool went back to where the move began.
    [[nodiscard]] MoveResult guarded_move(const Point& target, Pace pace) override;
    void stop() override;

    // Homes it where the options say so, it is not homed and can be. Throws DeviceAlarm if it is not homed, moves or has a fault,
    // ProbeClosed if the probe is closed, PositionLost if homing was stopped.
    void make_ready();
    // Off a surface that the probe was left on, straight towards `target`.
    void retreat(const Point& target);
    [[nodiscard]] const ExternalHello& hello() const { return hello_; }
    [[nodiscard]] ExternalState state();
    [[nodiscard]] const ExternalOptions& options() const { return options_; }
    [[nodiscard]] std::string name() const;

private:
    struct End;
    struct Watch;
    enum class OnStop {
        go_back,  // ends the move, and goes back to where it began
        stay,     // ends the move
        finish,   // goes on: it leads off a surface, and is short
    };
    void greet();
    // One move, to its end. Whatever comes that cannot be true, the program is told to stop.
    [[nodiscard]] End run(const Way& way, Pace pace, bool until_open, OnStop on_stop);
    // The next line, if there is one by the next sign of life, of the question `id` or a sign of life itself; says ours.
    [[nodiscard]] std::optional<external::Line> listen(Watch& watch, std::uint64_t id);
    [[nodiscard]] bool is_silent(const Watch& watch) const;
    [[nodiscard]] End wait_for_end(const Way& way, std::uint64_t move, double feed_mm_per_s, OnStop on_stop);
    // The same off a surface: a refusal is the probe's, which bounced since it was told of.
    [[nodiscard]] End run_off(const Way& way, bool until_open);
    void home();
    // Throws DeviceAlarm if it cannot move. Nothing is sent.
    void require_able(const ExternalState& state) const;
    // The machine as it is, able to move and at `start`; what it is not throws.
    [[nodiscard]] ExternalState ready_at(const Point& start);
    [[noreturn]] void fail_refused(const Way& way, const std::string& why);
    // Of a move that it is told to stop.
    [[nodiscard]] End stop_move(const Way& way, std::uint64_t move);
    [[nodiscard]] End to_end(const external::Line& line);
    void check(const End& end, const Way& way, double feed_mm_per_s);
    void check_seen(const Way& way, const Point& reported);
    // Towards `start` until the probe is open, and on to a retract before where it opened; to the start at most.
    void back_off(const Point& contact, const Point& start, bool is_closed);
    // On to `start`, from where back_off() ended.
    void go_to(const Point& start, OnStop on_stop = OnStop::finish);
    [[nodiscard]] bool opens_soon();
    [[noreturn]] void go_back_and_throw(const Way& way, const End& end);
    void ask_to_stop() noexcept;
    // Throws BadAnswer.
    [[noreturn]] void lose(const std::string& what);
    [[nodiscard]] double tolerance() const;
    [[nodiscard]] bool is_at(const Point& target) const { return (target - position_).norm() <= options_.motion.resolution_mm; }

    const ExternalOptions options_;
    const StopToken stop_;
    std::unique_ptr<external::Talk> talk_;
    ExternalHello hello_;
    Point position_ = Point::Zero();  // mm, machine coordinates
    bool is_lost_ = false;
};

}  // namespace palpate
