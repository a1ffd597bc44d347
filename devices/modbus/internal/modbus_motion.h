// One armed move of a Modbus controller, from its command to standstill: keeps the heartbeat up, and survives lost answers and connections.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "devices/errors.h"
#include "devices/internal/way.h"
#include "devices/modbus/internal/modbus_client.h"
#include "devices/motion_model.h"
#include "devices/probe_device.h"
#include "devices/stop_request.h"

namespace palpate {

// A position that the tool cannot have. The axes have been halted; nothing may be sent that is computed from such a report.
class FalseReport : public BadAnswer {
public:
    using BadAnswer::BadAnswer;
};

struct ArmedMove {
    Way way;  // on which every report has to lie; the move begins and ends on it
    Point target = Point::Zero();
    double feed_mm_per_s = 0.0;
    ProbeEdge edge = ProbeEdge::closing;
};

struct MotionEnd {
    ModbusStatus status;     // at standstill
    int edges = 0;           // closing edges that were counted on the way
    bool is_stored = false;  // the edge that was armed was latched
    bool is_at_target = false;
    std::vector<DeviceEvent::Kind> events{};
};

class ModbusMotion {
public:
    // `client`, `motion` and `clock` must outlive it. A move may take `patience` longer than twice what it should.
    ModbusMotion(ModbusClient& client, const MotionModel& motion, Clock& clock, Seconds patience)
        : client_(client), motion_(motion), clock_(clock), patience_(patience) {}

    // REQUIRES: `before` is the status just now: standing, no fault.
    // Throws Stopped as soon as the token says so, and DeviceTimeout, BadAnswer, DeviceRefused: the axes may still move, stop() them.
    // Throws DeviceAlarm when somebody else has the machine (fault, drives disabled, quick stop, a command of another master): send
    // nothing more. Throws FalseReport when the axes stand, PositionLost if the controller has restarted, ConnectionLost when the
    // connection came back but the controller had given up the move, and when it did not come back.
    [[nodiscard]] MotionEnd run(const ModbusStatus& before, const ArmedMove& move, const StopToken& stop);
    // What the machine says after that time, in which nothing is sent.
    [[nodiscard]] ModbusStatus look_after(std::chrono::nanoseconds time);
    // Slows down and waits for standstill. A heartbeat fault is reset: the position stays true. Throws as run, never Stopped.
    ModbusStatus stop();
    // Halts the axes if they move, and throws FalseReport with what is to be done.
    [[noreturn]] void refuse(const ModbusStatus& status, const std::string& what);
    // Throws DeviceAlarm unless the drives are enabled and the last command was ours.
    void require_ours(const ModbusStatus& status) const;

    // mm: how far a report may be off, along the way and beside it.
    [[nodiscard]] double tolerance() const;
    [[nodiscard]] bool is_near(const Point& a, const Point& b) const;

private:
    struct Watch;

    void send(const ArmedMove& move, Watch& watch);
    [[nodiscard]] std::uint16_t next_sequence(std::uint16_t echoed);
    void reconnect(Watch& watch, const StopToken& stop);
    [[nodiscard]] ModbusStatus status_through_reconnects(Watch& watch, const StopToken& stop);
    [[nodiscard]] std::optional<MotionEnd> judge(const ModbusStatus& status, const ArmedMove& move, Watch& watch);
    [[nodiscard]] bool is_taken(const ModbusStatus& status, Watch& watch);
    void require_our_command(const ModbusStatus& status) const;
    void require_homed(const ModbusStatus& status, const ArmedMove& move) const;
    [[noreturn]] void give_up_untaken(const ModbusStatus& status, const Watch& watch) const;
    [[nodiscard]] bool is_credible(const ModbusStatus& status, const ArmedMove& move, Watch& watch);
    void go_on(const ModbusStatus& status, const ArmedMove& move, Watch& watch);
    void require_in_time(const ModbusStatus& status, std::chrono::nanoseconds looked_at, const ArmedMove& move, const Watch& watch) const;
    void drop_set_point(const ModbusStatus& status, Watch& watch);
    [[nodiscard]] std::string state_of(const ModbusStatus& status) const;

    ModbusClient& client_;
    const MotionModel& motion_;
    Clock& clock_;
    Seconds patience_;
    std::optional<std::uint16_t> last_sequence_{};  // that was sent
    std::uint16_t echoed_ = 0;                      // before it was sent
};

// "fault 0x8612: a target or a position beyond the limits"
[[nodiscard]] std::string fault_text(std::uint16_t code);

}  // namespace palpate
