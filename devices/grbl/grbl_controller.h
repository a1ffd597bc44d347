// One conversation with a GRBL-family controller: connecting, reading, stopping, and the ways out of alarms. Knows no geometry but
// where the machine says it is. GrblDevice moves the probe with it.
//
//   connecting --status--> locked | idle            locked --home, unlock--> idle
//   idle --G38--> probing --ok--> idle              probing --!, Hold:0, Ctrl-X, banner--> idle
//   any --ALARM--> alarm --(Ctrl-X where only that leads out)--> locked
//   any --silence, end of file, unexpected banner, error in a move--> lost      alarm, lost: nothing moves; a new connection starts over
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "devices/grbl/grbl_link.h"
#include "devices/stop_request.h"

namespace palpate::grbl {

enum class State { connecting, locked, idle, probing, hold, alarm, lost };
[[nodiscard]] const char* to_string(State state);

// Numbers of the `$` settings that matter here.
namespace setting {
inline constexpr int kInvertProbe = 6;
inline constexpr int kReportMask = 10;
inline constexpr int kReportInches = 13;
inline constexpr int kSoftLimits = 20;
inline constexpr int kHardLimits = 21;
inline constexpr int kHomingCycle = 22;
inline constexpr int kHomingDirections = 23;
inline constexpr int kLaserMode = 32;
inline constexpr int kStepsPerMm = 100;    // of x; y and z follow, likewise below
inline constexpr int kMaxRate = 110;       // mm/min
inline constexpr int kAcceleration = 120;  // mm/s²
inline constexpr int kMaxTravel = 130;     // mm
}  // namespace setting

// A board that opening its port has reset is deaf while its boot loader waits. What has been silent for half of that is sent a reset, twice
// at most; what is silent for all of it is no controller.
inline constexpr Seconds kBootTime{8};

enum class Firmware { grbl, grblhal, fluidnc };

// What the machine says of itself.
struct Identity {
    std::string version;  // "1.1h.20190825:" as $I has it, or the banner's
    Firmware firmware = Firmware::grbl;
    std::map<int, std::string> settings;  // $$
    [[nodiscard]] std::optional<double> number(int setting) const;
};

// Where the machine is, in mm and machine coordinates.
struct Place {
    std::string state;  // "Idle"
    std::optional<int> substate;
    Point position = Point::Zero();
    bool probe_closed = false;
    bool probe_unplugged = false;
    std::optional<bool> homed;  // where the firmware says so; as of the last report that did
};

// What runs besides the axes, and how fast the axes go of what they are told.
struct Conditions {
    std::string running;               // S or C spindle, F flood, M mist: letters of A in reports
    std::optional<int> feed_override;  // %; nothing where no report told it
};

// Every call throws ConnectionLost, DeviceTimeout (with what was awaited and the last lines both ways), DeviceAlarm, or PositionLost
// if the machine started anew.
class Controller {
public:
    // `stream` and `clock` must outlive it. `delay`: what an answer may take beyond what the controller itself needs, as on a network.
    Controller(ByteStream& stream, Clock& clock, std::chrono::milliseconds delay = {}, Seconds boot_time = kBootTime)
        : link_(stream, clock), delay_(delay), boot_time_(to_nanoseconds(boot_time)) {}

    // Waits for the controller to answer, for a motion that an earlier host began to end, and reads all it says of itself. Moves nothing.
    // Throws Stopped once `stop` is requested; what moves is stopped.
    void connect(const StopToken& stop);
    // $H, as long as that takes. REQUIRES: locked or idle.
    // Throws Stopped if `stop` is requested before, PositionLost once it is requested while it moves: homing cannot be held.
    void home(const StopToken& stop);
    // $X. REQUIRES: locked.
    void unlock();
    // Feed hold, standstill, reset, banner: the way to stop that keeps the position. Does nothing if nothing moves.
    void stop();

    [[nodiscard]] Place place();
    // The same, from two reports that agree: a byte that got lost may leave another number. REQUIRES: nothing moves.
    [[nodiscard]] Place resting_place();
    // $#: the last probing move as the controller remembers it, in mm.
    [[nodiscard]] ProbeReport last_probe();
    // What "G90 G21" coordinates are relative to, in mm. Asks until two reports agree. REQUIRES: connected.
    [[nodiscard]] const Point& work_offset();

    // $G: what is commanded to run, in the letters of Conditions.
    [[nodiscard]] std::string active_accessories();
    // As the machine reports it; nothing if no report in a row long enough does. REQUIRES: nothing moves.
    [[nodiscard]] std::optional<int> feed_override();
    void reset_feed_override() { link_.send_realtime(kFeedOverrideTo100); }
    // By the last reports that told. What ran stays until forget_conditions() or a reset, which ends it.
    [[nodiscard]] const Conditions& conditions() const { return conditions_; }
    void forget_conditions() { conditions_ = {}; }

    [[nodiscard]] State state() const { return state_; }
    [[nodiscard]] const Identity& identity() const { return identity_; }
    [[nodiscard]] Link& link() { return link_; }
    [[nodiscard]] std::chrono::milliseconds delay() const { return delay_; }
    // From the units of reports to mm.
    [[nodiscard]] double unit_mm() const;

    // For who sends motion. Sends a line and says that its answer is due; what came before it is none.
    void begin(const std::string& line);
    // The answer has come, or never will.
    void end() { state_ = State::idle; }
    // Nothing that it says can be relied on any more.
    void give_up() { state_ = State::lost; }
    // The next message until then. Alarms and banners are dealt with, and throw.
    [[nodiscard]] std::optional<Message> next(std::chrono::nanoseconds until);
    // Lets time pass; what has come or comes is dealt with as there, and dropped.
    void pass_until(std::chrono::nanoseconds until);
    // A status report as a place; nothing if it says WPos and the offset is not known.
    [[nodiscard]] std::optional<Place> note(const Status& status);
    // Stops what may move, and clears what an error leaves behind: grblHAL repeats it until then.
    [[noreturn]] void fail(const Error& error);
    [[noreturn]] void fail_silent(const std::string& awaited);

private:
    // Sends a line and collects what comes until the `ok` that follows the first message that `is_answer`: an `ok` without that is
    // an older command's.
    std::vector<Message> ask(const std::string& line, const std::function<bool(const Message&)>& is_answer);
    [[nodiscard]] bool wait_for_first_status(const StopToken& stop);
    // Throws DeviceTimeout: of what is no controller that is known here.
    [[noreturn]] void fail_unknown();
    void read_identity();
    // Throws DeviceRefused if reports leave out what a session needs.
    void require_reports() const;
    void clear_motion_mode();
    [[nodiscard]] Place wait_for_standstill(std::chrono::nanoseconds longest, const StopToken& stop = {});
    void reset();
    // Ctrl-X until the banner comes; false if none does.
    [[nodiscard]] bool reset_until_banner(std::chrono::nanoseconds until, const StopToken& stop = {});
    // Throws Stopped: of a machine that has said nothing yet.
    [[noreturn]] void stop_unheard();
    void note_conditions(const Status& status);
    void note_offset(const Point& offset);
    void forget_offset();
    [[noreturn]] void on_alarm(const Alarm& alarm);

    Link link_;
    const std::chrono::milliseconds delay_;
    const std::chrono::nanoseconds boot_time_;
    std::string unknown_;  // the last line that was none of a controller's, while connecting
    State state_ = State::connecting;
    Identity identity_;
    std::optional<Point> work_offset_;
    std::optional<Point> doubtful_offset_;  // another one, told once
    bool is_offset_sure_ = false;           // told twice
    bool has_reported_ = false;             // its status, readably
    std::optional<bool> homed_;
    Conditions conditions_;
    bool has_motion_mode_ = true;  // one that an axis word alone would move with, for all that is known
};

}  // namespace palpate::grbl
