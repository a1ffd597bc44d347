// A touch probe on a machine whose controller speaks Modbus (register map: devices/modbus/modbus_profile.h).
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "devices/clock.h"
#include "devices/errors.h"
#include "devices/modbus/modbus_link.h"
#include "devices/modbus/modbus_profile.h"
#include "devices/motion_model.h"
#include "devices/probe_device.h"
#include "devices/stop_request.h"
#include "planner/region.h"

namespace palpate {

class ModbusClient;
class ModbusMotion;
struct ModbusStatus;
struct MotionEnd;
struct Way;
enum class ProbeEdge;

struct ModbusDeviceOptions {
    ModbusLinkOptions link;
    ModbusProfile profile = ModbusProfile::standard();
    MotionModel motion;            // has to be what the controller does
    Point origin = Point::Zero();  // mm: our origin in machine coordinates
    Seconds patience{2.0};         // a move may take so much longer than twice what it should
};

// What `palpate check` shows. Positions and limits are machine coordinates in mm.
struct ModbusReport {
    std::string link;
    std::string profile;
    std::string identity;
    Box limits;
    Point position = Point::Zero();
    bool is_homed = false;
    bool is_standing = false;
    bool is_enabled = false;
    bool is_probe_closed = false;
    bool is_in_fault = false;
    int fault_code = 0;             // 0: none is told
    double position_unit_mm = 0.0;  // of one count
    double resolution_mm = 0.0;     // that the configuration gives
    Seconds look_time{0};           // the longest of some: a heartbeat and the status
    int look_requests = 2;          // in how many requests
    Seconds heartbeat_limit{0};     // within which the controller wants the next heartbeat

    // What is wrong and what to do; empty: nothing.
    [[nodiscard]] std::string position_problem() const;
    [[nodiscard]] std::string unit_problem() const;
    [[nodiscard]] std::string timing_problem() const;
    [[nodiscard]] std::string timing_text() const;
    [[nodiscard]] std::vector<std::string> lines() const;
};

// Speaks Palpate's coordinates: machine coordinates less `origin`. One thread uses it; the stop token may be used from anywhere.
class ModbusDevice final : public ProbeDevice {
public:
    // The state machine is drawn in devices/README.md.
    enum class State {
        connecting,
        locked,    // not homed, in fault, or the probe is closed: nothing moves until recover() finds the cause gone
        idle,      // stands where position() says
        moving,    // within guarded_move
        stopping,  // slows down, then backs off the way that it came
        fault,     // something failed in mid-move; recover()
        lost,      // no connection; recover()
    };

    // Connects, and moves nothing. A machine that is not ready leaves the device `locked`, so that it can still be reported.
    // `clock` must outlive the device.
    // Throws ConnectionLost; DeviceError if another process has the machine, it is another controller than the profile is for, or if a
    // stopping distance exceeds the overtravel; std::invalid_argument on a false profile.
    ModbusDevice(ModbusDeviceOptions options, Clock& clock, StopToken stop = {});
    ~ModbusDevice() override;
    ModbusDevice(const ModbusDevice&) = delete;
    ModbusDevice& operator=(const ModbusDevice&) = delete;
    ModbusDevice(ModbusDevice&&) = delete;
    ModbusDevice& operator=(ModbusDevice&&) = delete;

    [[nodiscard]] Point position() const override { return position_; }
    // After a contact the tool is back by motion.retract_mm, or at the start of the move if that is nearer, with the probe open.
    // Throws, and is `idle` then: OutOfLimits, ProbeClosed (before the move), Stopped, BadAnswer, DeviceRefused, DeviceTimeout. What of
    // these comes in mid-move first stops the tool and backs off along the way that it came, until the probe is open. If that fails too,
    // and on ProbeClosed after a touch, DeviceAlarm, PositionLost and ConnectionLost it is `fault`, `locked` or `lost`. So it is after a
    // BadAnswer that tells of a position beside the way: the axes are halted then, and nothing more is sent. On DeviceAlarm (a fault,
    // drives that were disabled, another master) nothing at all is sent.
    [[nodiscard]] MoveResult guarded_move(const Point& target, Pace pace) override;
    void stop() override;

    // The one way out of locked, fault and lost: connects again, resets a fault, and if the probe is pressed on by a move that failed,
    // goes back the way that move came, if the tool is said to be on it. Throws what is still in the way.
    void recover();

    // As recover(), for a tool that an earlier host left on a surface: off it towards `start`, which it came from. It has to be where it
    // was when last looked at (report(), or connecting).
    void retreat(const Point& start);

    [[nodiscard]] State state() const { return state_; }
    // Asks the controller; moves nothing.
    [[nodiscard]] ModbusReport report();

private:
    struct Ready;
    [[nodiscard]] Ready resting_status();
    [[nodiscard]] Ready ready();
    [[nodiscard]] MoveResult move(const Point& target, Pace pace);
    [[nodiscard]] MoveResult finish(const MotionEnd& end, const Way& way);
    void check_contact(const ModbusStatus& status, const Way& way) const;
    void check_run_on(const ModbusStatus& status, const Way& way);
    [[nodiscard]] ModbusStatus go(const ModbusStatus& status, const Way& way, double place, ProbeEdge edge);
    [[nodiscard]] ModbusStatus until_open(const ModbusStatus& status, const Way& way, double& rest);
    void draw_back(const ModbusStatus& status, const Way& way, double rest);
    void back_off(const Way& way);
    void go_back(const Way& way);
    void back_off_after(const DeviceError& failure, const Way& way);
    void leave_surface(const ModbusStatus& status);
    void halt_after_failure();
    void check_ready(const ModbusStatus& status);
    void check_reach(const ModbusStatus& status);
    void inspect();
    void check_target(const Point& machine) const;
    [[nodiscard]] std::string where() const;

    ModbusDeviceOptions options_;
    StopToken stop_;
    State state_ = State::connecting;
    std::unique_ptr<ModbusClient> client_;
    std::unique_ptr<ModbusMotion> motion_;
    std::string identity_;
    Box limits_;  // machine coordinates
    Point position_ = Point::Zero();
    Point seen_ = Point::Zero();     // machine coordinates: what was last reported
    bool was_enabled_ = false;       // by us
    bool shows_quick_stop_ = false;  // bit 5 of the status word was set: the controller tells of quick stops by it
    int timed_looks_ = 0;            // for the first report
    Seconds slowest_look_{0};
    std::unique_ptr<Way> way_back_;  // machine coordinates: of a move that failed
};

[[nodiscard]] std::string_view name_of(ModbusDevice::State state);

}  // namespace palpate
