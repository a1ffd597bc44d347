#include "devices/internal/modbus_motion.h"

#include <array>
#include <cstdio>
#include <utility>

#include "devices/errors.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

// Between looks at the status. Well below any heartbeat limit, and above what the slowest usual line (19200 baud) needs for a look.
constexpr std::chrono::milliseconds kPoll{10};
// How often a move goes on after the controller stopped because an answer was late.
constexpr int kContinuations = 5;
// Encoders stand within a count or two.
constexpr double kStandstillResolutions = 5.0;

std::chrono::nanoseconds nanoseconds(Seconds time) { return std::chrono::duration_cast<std::chrono::nanoseconds>(time); }

}  // namespace

std::string fault_text(std::uint16_t code) {
    std::array<char, 16> digits{};
    (void)std::snprintf(digits.data(), digits.size(), "0x%04X", static_cast<unsigned>(code));
    const auto meaning = [code] {
        switch (code) {
            case cia402::kParameterFault:
                return "a move without a velocity or an acceleration";
            case cia402::kHeartbeatFault:
                return "the host was silent, so it stopped";
            case cia402::kLimitFault:
                return "a target or a position beyond the limits";
            case cia402::kNotHomedFault:
                return "a move before homing";
            case cia402::kProbeClosedFault:
                return "a move towards a touch with the probe closed";
            default:
                return "look into the controller's manual";
        }
    };
    return std::string("fault ") + digits.data() + ": " + meaning();
}

// What is known of a move while it runs.
struct ModbusMotion::Watch {
    ModbusStatus before;
    std::uint16_t sequence = 0;  // of the last command; before the first, what was echoed
    std::chrono::nanoseconds deadline{0};
    std::uint64_t lost_answers = 0;
    int reconnects = 0;
    int continuations = 0;
    std::vector<DeviceEvent::Kind> events{};
};

bool ModbusMotion::is_near(const Point& a, const Point& b) const {
    return (a - b).norm() <= kStandstillResolutions * kinematics_.resolution_mm;
}

// Never the number of an earlier command: one that did not arrive may still come, and would be taken for this one. Nor the number that is
// echoed: it starts nothing.
std::uint16_t ModbusMotion::next_sequence(std::uint16_t echoed) {
    const auto after = [](std::uint16_t number) { return static_cast<std::uint16_t>(number + 1U); };  // wraps
    std::uint16_t next = after(last_sequence_.value_or(echoed));
    if (next == echoed) next = after(next);
    last_sequence_ = next;
    return next;
}

void ModbusMotion::send(const ArmedMove& move, Watch& watch) {
    watch.sequence = next_sequence(watch.sequence);
    try {
        client_.start({move.target, move.feed_mm_per_s, kinematics_.acceleration_mm_per_s2, move.edge, watch.sequence});
    } catch (const ConnectionLost&) {
        reconnect(watch);  // the echo will tell whether it arrived
    }
    const Seconds expected = move_duration(kinematics_, (move.target - watch.before.actual).norm(), move.feed_mm_per_s);
    watch.deadline = clock_.now() + nanoseconds(2 * expected + patience_);
}

void ModbusMotion::reconnect(Watch& watch) {
    ++watch.reconnects;
    client_.link().reconnect();
    watch.events.push_back(DeviceEvent::Kind::reconnected);
}

ModbusStatus ModbusMotion::status_through_reconnects(Watch& watch) {
    while (true) {
        try {
            return client_.status();
        } catch (const ConnectionLost&) {
            if (watch.reconnects >= client_.link().options().reconnects) throw;
        }
        reconnect(watch);
    }
}

// Nothing while the move goes on.
std::optional<MotionEnd> ModbusMotion::judge(const ModbusStatus& status, const ArmedMove& move, Watch& watch) {
    const std::string where = client_.link().name();
    if (!status.is_homed) {
        throw PositionLost(where + " is not homed any more: it was restarted during the move to " + point_text(move.target) + "; home it");
    }
    if (status.sequence != watch.sequence) {
        const std::string what =
            where + " shows command " + std::to_string(status.sequence) + " instead of " + std::to_string(watch.sequence);
        if (watch.reconnects > 0) throw ConnectionLost("the connection was lost before the command arrived: " + what + "; resume");
        throw BadAnswer(what + ": does someone else command it?");
    }
    if (!status.is_standing()) return std::nullopt;
    const bool was_silent = status.is_fault() && status.fault_code == cia402::kHeartbeatFault;
    if (was_silent) {
        client_.reset_fault();
    } else if (status.is_fault()) {
        throw DeviceAlarm(status.fault_code, where + ": " + fault_text(status.fault_code) + ", on the way to " + point_text(move.target) +
                                                 "; it stands at " + point_text(status.actual) +
                                                 " (machine); clear the cause, then recover");
    }
    MotionEnd end{.status = status};
    end.edges = static_cast<std::uint16_t>(status.edges - watch.before.edges);
    end.is_stored =
        (status.touch_status & (move.edge == ProbeEdge::closing ? cia402::kPositiveEdgeStored : cia402::kNegativeEdgeStored)) != 0;
    end.is_at_target = is_near(status.actual, move.target);
    // A touch that the controller missed: to go on would press the probe on.
    const bool is_missed = move.edge == ProbeEdge::closing && status.is_probe_closed;
    if (!was_silent || end.is_stored || end.edges != 0 || end.is_at_target || is_missed) return end;
    if (watch.reconnects > 0) {
        throw ConnectionLost("the connection to " + where + " was lost and is there again; the controller had stopped at " +
                             point_text(status.actual) + " (machine) before the move to " + point_text(move.target) + " was over; resume");
    }
    if (++watch.continuations > kContinuations) {
        throw DeviceTimeout(where + " stopped " + std::to_string(watch.continuations) + " times on the way to " + point_text(move.target) +
                            " because our heartbeat came late; look for what slows the line; " + client_.link().last_exchange());
    }
    watch.events.push_back(DeviceEvent::Kind::repeated_command);
    send(move, watch);
    return std::nullopt;
}

MotionEnd ModbusMotion::run(const ModbusStatus& before, const ArmedMove& move, const std::stop_token& stop) {
    Watch watch{.before = before, .sequence = before.sequence, .lost_answers = client_.lost_answers()};
    send(move, watch);
    while (true) {
        const ModbusStatus status = status_through_reconnects(watch);
        if (std::optional<MotionEnd> end = judge(status, move, watch)) {
            end->events = std::move(watch.events);
            const std::uint64_t lost = client_.lost_answers() - watch.lost_answers;
            end->events.insert(end->events.end(), lost, DeviceEvent::Kind::repeated_command);
            return *std::move(end);
        }
        if (stop.stop_requested()) throw Stopped("stopped on the way to " + point_text(move.target) + " (machine)");
        if (clock_.now() > watch.deadline) {
            throw DeviceTimeout("waited for " + client_.link().name() + " to end command " + std::to_string(watch.sequence) +
                                ", a move to " + point_text(move.target) + " (machine); it is at " + point_text(status.actual) +
                                " and still moves: does it take the velocity that it is given? " + client_.link().last_exchange());
        }
        clock_.sleep(kPoll);
    }
}

ModbusStatus ModbusMotion::stop() {
    client_.halt();
    const auto deadline = clock_.now() + nanoseconds(patience_);
    while (true) {
        ModbusStatus status = client_.status();
        if (status.is_standing()) {
            if (!status.is_fault()) return status;
            if (status.fault_code != cia402::kHeartbeatFault) {
                throw DeviceAlarm(status.fault_code, client_.link().name() + ": " + fault_text(status.fault_code) + "; clear the cause");
            }
            client_.reset_fault();
            return client_.status();
        }
        if (clock_.now() > deadline) {
            throw DeviceTimeout("waited for " + client_.link().name() + " to stand still after a halt; use the emergency stop; " +
                                client_.link().last_exchange());
        }
        clock_.sleep(kPoll);
    }
}

}  // namespace palpate
