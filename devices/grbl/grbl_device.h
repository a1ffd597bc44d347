// The ProbeDevice on a GRBL-family controller: guarded moves by G38.3, nothing else ever moves but homing.
#pragma once

#include <chrono>
#include <string>

#include "devices/grbl/grbl_controller.h"
#include "devices/homing.h"
#include "devices/motion_model.h"
#include "devices/probe_device.h"
#include "devices/stop_request.h"

namespace palpate {

struct Way;

struct GrblOptions {
    MotionModel motion;
    Point origin = Point::Zero();  // mm, machine coordinates: where Palpate's coordinates have their origin
    Homing homing = Homing::require;
    std::chrono::milliseconds delay{0};   // what an answer may take beyond what the controller itself needs, as on a network
    Seconds boot_time = grbl::kBootTime;  // from the opening of a port that resets the board to its first answer
};

// Positions are Palpate's: the machine's less the origin. The contact is what the controller latched ([PRB:…:1]), never where it
// came to rest; an answer counts only if it lies on the way and agrees with where the machine then is. What the machine reports only
// ever selects a point of the commanded way: else nothing more is sent, and BadAnswer says so.
class GrblDevice final : public ProbeDevice {
public:
    // Connects (Controller::connect) and moves nothing. `stream` and `clock` must outlive the device. Once `stop` is requested, a move
    // that is under way is ended, the tool goes back to where that move began, and Stopped is thrown.
    GrblDevice(ByteStream& stream, Clock& clock, const GrblOptions& options, StopToken stop = {});

    // Makes the machine fit to move, as `homing` says: this may home it. Throws DeviceError before anything moves if spindle, laser or
    // coolant run or a feed override above 100 % stays, DeviceAlarm if the machine is locked and may not be homed, and ProbeClosed if the
    // probe is closed. To be called before the first move.
    void make_ready();

    [[nodiscard]] Point position() const override { return position_ - options_.origin; }
    // Throws, besides what Controller does, ProbeClosed, BadAnswer and Stopped; and DeviceError if something was switched on that
    // make_ready refuses, after the tool went back as for a stop.
    [[nodiscard]] MoveResult guarded_move(const Point& target, Pace pace) override;
    void stop() override { controller_.stop(); }

    // Away from what a probe that is closed touches, straight to `target`; for a tool that an earlier host left on a surface. Once
    // `stop` is requested it ends where it is.
    void retreat(const Point& target);
    [[nodiscard]] bool is_probe_closed() { return controller_.place().probe_closed; }

    [[nodiscard]] grbl::Controller& controller() { return controller_; }
    [[nodiscard]] const GrblOptions& options() const { return options_; }

private:
    struct ProbeEnd {
        grbl::ProbeReport report;  // mm, machine coordinates
        grbl::Place place;         // at rest, after it
        bool repeated = false;     // the answer was lost
    };
    // What a move does that a stop is requested in.
    enum class OnStop {
        go_back,  // ends, and goes back to where it began
        stay,     // ends
        finish,   // goes on: it leads off a surface, and is short
    };
    // Throws DeviceError if something runs besides the axes, or they would be faster than they are told.
    void require_quiet();
    // What of that the last reports told: empty, or what is on and what ends it.
    [[nodiscard]] std::string disturbance() const;
    [[nodiscard]] std::string disturbance(const grbl::Conditions& conditions) const;
    void refuse_disturbed();
    void slow_down_disturbed();
    [[noreturn]] void stop_disturbed(const Way& way, OnStop on_stop);
    // Throws DeviceError if the machine stops more slowly than was reckoned with.
    void check_acceleration();
    // One G38 to a machine position. `word`: "G38.3" or "G38.5".
    ProbeEnd run_probe(const std::string& word, const Point& target, double feed_mm_per_s, OnStop on_stop);
    // Nothing if the machine stands and its answer did not come.
    [[nodiscard]] std::optional<ProbeEnd> wait_for_end(const Way& way, std::chrono::nanoseconds longest, OnStop on_stop);
    // Whether the probe stayed closed after a contact (MoveResult::held).
    [[nodiscard]] bool holds(const ProbeEnd& end, const Point& start, double feed_mm_per_s);
    // Then: what did it do? Nothing if it never heard the command.
    [[nodiscard]] std::optional<ProbeEnd> find_out(const Point& start, const grbl::ProbeReport& before);
    // An answer that cannot be true is never passed on. Throws BadAnswer.
    void check_answer(ProbeEnd& end, const Way& way, double feed_mm_per_s);
    // What is wrong with it, or empty.
    [[nodiscard]] std::string problem_of(const ProbeEnd& end, const Way& way) const;
    void check_again(const ProbeEnd& end, double feed_mm_per_s);
    void check_overrun(double overrun, double feed_mm_per_s);
    // Of a machine at rest. Throws BadAnswer.
    void check_on(const Segment& way, const Point& reported);
    // A tool that moves elsewhere than it was told is stopped.
    [[nodiscard]] bool is_off(const Way& way, const grbl::Place& place) const;
    void stop_off_way(const Way& way);
    [[noreturn]] void fail_state(const std::string& state);
    [[nodiscard]] double longest_overrun(double feed_mm_per_s) const;  // mm
    [[noreturn]] void stop_and_throw(const Way& way, OnStop on_stop);
    // Ends a move on its way, with the position kept.
    void stop_on(const Way& way);
    // After a touch at `contact` of a move from `start`: back until the probe is open, and on to a place before the touch.
    void retract(const Point& contact, const Point& start, double feed_mm_per_s);
    // From position() to `target`, guarded both ways: until the probe opens, then until it closes. If it is closed there yet, on towards
    // `start` until it opens, and a retract beyond. Throws ProbeClosed if it is closed at `start`.
    void back_off(Point target, const Point& start, OnStop on_stop);
    // Whether a probe that is closed where nothing should be was only bouncing.
    [[nodiscard]] bool opens_soon();
    // mm: the longest step of an axis, and the last digit of what the machine reports.
    [[nodiscard]] double step() const;
    [[nodiscard]] double last_digit() const;
    // mm: how exactly the machine can say where it is.
    [[nodiscard]] double tolerance() const;
    // Whether the tool is at that machine position, as far as the machine can tell. Steps that are coarser than what it was told, and
    // digits that are coarser than its steps (inches), keep it from saying so exactly.
    [[nodiscard]] bool is_at(const Point& target) const;

    grbl::Controller controller_;
    const GrblOptions options_;
    const StopToken stop_;
    Point position_ = Point::Zero();  // mm, machine coordinates
    std::string disturbed_;           // what was seen that ends the session
    bool is_quiet_ = false;           // require_quiet() has been
    std::optional<grbl::ProbeReport> last_;
};

}  // namespace palpate
