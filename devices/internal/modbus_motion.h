// One armed move of a Modbus controller, from its command to standstill: keeps the heartbeat up, and survives lost answers and connections.
#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "devices/internal/modbus_client.h"
#include "devices/kinematics.h"
#include "devices/probe_device.h"

namespace palpate {

struct ArmedMove {
    Point target = Point::Zero();  // mm, machine coordinates
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
    // `client`, `kinematics` and `clock` must outlive it. A move may take `patience` longer than twice what it should.
    ModbusMotion(ModbusClient& client, const Kinematics& kinematics, Clock& clock, Seconds patience)
        : client_(client), kinematics_(kinematics), clock_(clock), patience_(patience) {}

    // REQUIRES: `before` is the status just now: standing, no fault.
    // Throws Stopped as soon as the token says so, and DeviceTimeout, BadAnswer, DeviceRefused: the axes may still move, stop() them.
    // Throws DeviceAlarm on a fault, PositionLost if the controller has restarted, ConnectionLost when the connection came back but the
    // controller had given up the move, and when it did not come back.
    [[nodiscard]] MotionEnd run(const ModbusStatus& before, const ArmedMove& move, const std::stop_token& stop);
    // Slows down and waits for standstill. A heartbeat fault is reset: the position stays true. Throws as run, never Stopped.
    ModbusStatus stop();

    [[nodiscard]] bool is_near(const Point& a, const Point& b) const;

private:
    struct Watch;

    void send(const ArmedMove& move, Watch& watch);
    [[nodiscard]] std::uint16_t next_sequence(std::uint16_t echoed);
    void reconnect(Watch& watch);
    [[nodiscard]] ModbusStatus status_through_reconnects(Watch& watch);
    [[nodiscard]] std::optional<MotionEnd> judge(const ModbusStatus& status, const ArmedMove& move, Watch& watch);

    ModbusClient& client_;
    const Kinematics& kinematics_;
    Clock& clock_;
    Seconds patience_;
    std::optional<std::uint16_t> last_sequence_{};  // that was sent
};

// "fault 0x8612: a target or a position beyond the limits"
[[nodiscard]] std::string fault_text(std::uint16_t code);

}  // namespace palpate
