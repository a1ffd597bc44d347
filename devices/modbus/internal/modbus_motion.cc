#include "devices/modbus/internal/modbus_motion.h"

#include <fmt/format.h>

#include <utility>

#include "devices/clock.h"
#include "devices/errors.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

// From one look at the status to the next, where answers are faster than that.
constexpr std::chrono::milliseconds kPoll{10};
// How often a move goes on after the controller stopped because an answer was late.
constexpr int kContinuations = 5;
// Encoders stand within a count or two.
constexpr double kStandstillResolutions = 5.0;
// mm: axes that follow a slanted line lag behind it by different amounts; a report farther off belongs to another move, or to none.
constexpr double kPathTolerance = 0.05;
// Rounding of the report, of the start and of the target, each half a resolution per axis: √3 · 3/2.
constexpr double kRoundingResolutions = 2.6;
// Of a 32-bit value that a controller changes between its two words, a look sees nonsense, once.
constexpr int kFalseReports = 2;
// Of the time that the controller waits for a heartbeat, what may pass between two when the set-point bit is taken back.
constexpr double kHeartbeatShare = 0.9;

}  // namespace

std::string fault_text(std::uint16_t code) {
    const auto meaning = [code] {
        switch (code) {
            case cia402::kParameterFault:
                return "a move without a velocity or an acceleration";
            case cia402::kExternalFault:
                return "something outside of it, an emergency stop perhaps";
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
    return fmt::format("fault 0x{:04X}: {}", code, meaning());
}

// What is known of a move while it runs.
struct ModbusMotion::Watch {
    ModbusStatus before;
    std::uint16_t sequence = 0;  // of the last command
    std::uint16_t previous = 0;  // that was echoed before it
    bool is_taken = false;       // its number was echoed
    bool is_set_point_up = true;
    bool shows_quick_stop = false;  // a controller that never sets the bit does not tell of quick stops
    std::chrono::nanoseconds taken_by{0};
    std::chrono::nanoseconds deadline{0};
    std::uint64_t lost_answers = 0;
    int reconnects = 0;
    int continuations = 0;
    int false_reports = 0;
    std::vector<DeviceEvent::Kind> events{};
};

bool ModbusMotion::is_near(const Point& a, const Point& b) const {
    return (a - b).norm() <= kStandstillResolutions * motion_.resolution_mm;
}

double ModbusMotion::tolerance() const { return kPathTolerance + kRoundingResolutions * motion_.resolution_mm; }

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
    echoed_ = watch.previous;
    watch.sequence = next_sequence(watch.previous);
    watch.is_taken = false;
    watch.is_set_point_up = true;
    try {
        client_.start({move.target, move.feed_mm_per_s, motion_.acceleration_mm_per_s2, move.edge, watch.sequence});
    } catch (const ConnectionLost&) {
        reconnect(watch, {});  // the echo will tell whether it arrived
    }
    watch.taken_by = clock_.now() + to_nanoseconds(client_.profile().echo_limit);
    const Seconds expected = move_duration(motion_, (move.target - watch.before.actual).norm(), move.feed_mm_per_s);
    watch.deadline = clock_.now() + to_nanoseconds(2 * expected + patience_);
}

void ModbusMotion::reconnect(Watch& watch, const StopToken& stop) {
    ++watch.reconnects;
    client_.link().reconnect(stop);
    watch.events.push_back(DeviceEvent::Kind::reconnected);
}

// A network that is away is waited for; without a heartbeat the axes have stopped by then.
ModbusStatus ModbusMotion::status_through_reconnects(Watch& watch, const StopToken& stop) {
    const auto give_up_at = clock_.now() + to_nanoseconds(client_.link().options().reconnect_time);
    while (true) {
        try {
            return client_.status();
        } catch (const ConnectionLost&) {
            if (watch.reconnects >= client_.link().options().reconnects) throw;
        } catch (const DeviceTimeout&) {
            if (stop.stop_requested() || clock_.now() >= give_up_at) throw;
        }
        if (!client_.link().is_connected()) reconnect(watch, stop);
    }
}

std::string ModbusMotion::state_of(const ModbusStatus& status) const {
    if (status.is_fault()) return fault_text(status.fault_code);
    return status.has(cia402::kOperationEnabled) ? "its drives are enabled" : "its drives are disabled";
}

void ModbusMotion::require_ours(const ModbusStatus& status) const {
    if (!status.has(cia402::kOperationEnabled)) {
        throw DeviceAlarm(0, fmt::format("{}: {}, by an emergency stop perhaps; nothing more was sent to it, and the tool may be pressed; "
                                         "look at it, clear the cause, then recover",
                                         client_.link().name(), state_of(status)));
    }
    require_our_command(status);
}

void ModbusMotion::require_our_command(const ModbusStatus& status) const {
    if (!last_sequence_ || status.sequence == *last_sequence_ || status.sequence == echoed_) return;
    throw DeviceAlarm(0, fmt::format("{}: another master commands it: command {} instead of {}; nothing more was sent to it; end what else "
                                     "commands it, look where the tool is, then recover",
                                     client_.link().name(), status.sequence, *last_sequence_));
}

void ModbusMotion::require_homed(const ModbusStatus& status, const ArmedMove& move) const {
    if (status.is_homed) return;
    throw PositionLost(fmt::format("{} is not homed any more: it was restarted during the move to {}; home it", client_.link().name(),
                                   point_text(move.target)));
}

// A controller that works in cycles shows a command in one of its next.
bool ModbusMotion::is_taken(const ModbusStatus& status, Watch& watch) {
    if (status.sequence == watch.sequence) {
        watch.is_taken = true;
        echoed_ = watch.sequence;
    }
    if (watch.is_taken || status.sequence != watch.previous) return true;
    if (clock_.now() >= watch.taken_by) give_up_untaken(status, watch);
    return false;
}

void ModbusMotion::give_up_untaken(const ModbusStatus& status, const Watch& watch) const {
    const std::string what =
        fmt::format("{} did not take a command: it shows command {} instead of {}", client_.link().name(), status.sequence, watch.sequence);
    if (watch.reconnects > 0) {
        throw ConnectionLost(fmt::format("the connection was lost before the command arrived: {}; resume", what));
    }
    const std::string state = state_of(status);
    if (status.is_fault()) throw DeviceAlarm(status.fault_code, fmt::format("{}: {}; clear the cause, then recover", what, state));
    if (!status.has(cia402::kOperationEnabled)) throw DeviceAlarm(0, fmt::format("{}: {}; look at it, then recover", what, state));
    throw BadAnswer(fmt::format("{}, and says that {}", what, state));
}

// Whether the tool can be where it is said to be. Twice in a row not: FalseReport.
bool ModbusMotion::is_credible(const ModbusStatus& status, const ArmedMove& move, Watch& watch) {
    const double off = move.way.distance_to(status.actual);
    if (off <= tolerance()) {
        watch.false_reports = 0;
        return true;
    }
    if (++watch.false_reports < kFalseReports) return false;
    refuse(status, fmt::format("{} says that the tool is at {}, {:f} mm off the way from {} to {} (machine)", client_.link().name(),
                               point_text(status.actual), off, point_text(move.way.start), point_text(move.way.target)));
}

void ModbusMotion::refuse(const ModbusStatus& status, const std::string& what) {
    std::string halted = "the axes stand";
    if (!status.is_standing()) {
        halted = "the axes were halted";
        try {
            (void)stop();
        } catch (const DeviceError& error) {
            halted = fmt::format("to halt the axes failed: {}", error.what());
        }
    }
    throw FalseReport(
        fmt::format("{}, where it cannot be; {}; nothing else is sent, since nobody knows where the tool is; it {} pressed on: look at it, "
                    "bring it off by the machine's own means, mend what reports the positions, then recover",
                    what, halted, status.is_probe_closed ? "is" : "may be"));
}

// The controller had stopped because our heartbeat came late: the rest of the move.
void ModbusMotion::go_on(const ModbusStatus& status, const ArmedMove& move, Watch& watch) {
    const std::string where = client_.link().name();
    if (watch.reconnects > 0) {
        throw ConnectionLost(
            fmt::format("the connection to {} was lost and is there again; the controller had stopped at {} (machine) before the move to "
                        "{} was over; resume",
                        where, point_text(status.actual), point_text(move.target)));
    }
    if (++watch.continuations > kContinuations) {
        throw DeviceTimeout(
            fmt::format("{} stopped {} times on the way to {} because our heartbeat came late; look for what slows the line; {}", where,
                        watch.continuations, point_text(move.target), client_.link().last_exchange()));
    }
    watch.events.push_back(DeviceEvent::Kind::repeated_command);
    watch.previous = status.sequence;
    send(move, watch);
}

// Nothing while the move goes on.
std::optional<MotionEnd> ModbusMotion::judge(const ModbusStatus& status, const ArmedMove& move, Watch& watch) {
    require_homed(status, move);
    if (!is_taken(status, watch)) return std::nullopt;
    require_our_command(status);
    const bool was_silent = status.is_fault() && status.fault_code == cia402::kHeartbeatFault;
    if (!status.is_fault()) {
        require_ours(status);
        watch.shows_quick_stop = watch.shows_quick_stop || status.has(cia402::kQuickStopInactive);
        if (watch.shows_quick_stop && !status.has(cia402::kQuickStopInactive)) {
            throw DeviceAlarm(
                0, fmt::format("{}: quick stop on the way to {} (machine); nothing more was sent to it; clear the cause, then recover",
                               client_.link().name(), point_text(move.target)));
        }
    } else if (!was_silent) {
        if (!status.is_standing()) return std::nullopt;
        throw DeviceAlarm(status.fault_code,
                          fmt::format("{}: {}, on the way to {}; it stands at {} (machine); nothing more was sent to it; clear the cause, "
                                      "then recover",
                                      client_.link().name(), state_of(status), point_text(move.target), point_text(status.actual)));
    }
    if (!is_credible(status, move, watch) || !status.is_standing()) return std::nullopt;
    if (was_silent) client_.reset_fault();
    MotionEnd end{.status = status};
    end.edges = static_cast<std::uint16_t>(status.edges - watch.before.edges);
    end.is_stored =
        (status.touch_status & (move.edge == ProbeEdge::closing ? cia402::kPositiveEdgeStored : cia402::kNegativeEdgeStored)) != 0;
    end.is_at_target = is_near(status.actual, move.target);
    // A touch that the controller missed: to go on would press the probe on.
    const bool is_missed = move.edge == ProbeEdge::closing && status.is_probe_closed;
    if (!was_silent || end.is_stored || end.edges != 0 || end.is_at_target || is_missed) return end;
    go_on(status, move, watch);
    return std::nullopt;
}

// A controller after CiA 402 takes a command at the rising edge of the set-point bit. So it falls while the axes move, which costs no
// time, and when they stand only where the heartbeat would come too late otherwise, or the move was over before the first look.
void ModbusMotion::drop_set_point(const ModbusStatus& status, Watch& watch) {
    if (!watch.is_taken || !watch.is_set_point_up || status.is_fault()) return;
    const int requests = client_.look_requests();
    const bool fits = (requests + 1) * client_.look_time() / requests < kHeartbeatShare * client_.profile().heartbeat_limit;
    if (!status.is_standing() && !fits) return;
    watch.is_set_point_up = false;
    if (!status.is_standing()) return client_.take_back_set_point();
    try {
        client_.take_back_set_point();
        // A cycle of the controller's has to see it down; slow answers leave it time enough.
        if (fits) (void)client_.status();
    } catch (const DeviceError&) {
        return;  // the move has ended, and what fails here fails again at the next
    }
}

void ModbusMotion::require_in_time(const ModbusStatus& status, std::chrono::nanoseconds looked_at, const ArmedMove& move,
                                   const Watch& watch) const {
    // What it said before counts for nothing: this process may have been stopped meanwhile.
    if (looked_at <= watch.deadline) return;
    throw DeviceTimeout(fmt::format(
        "waited for {} to end command {}, a move to {} (machine); it is at {} and still moves: does it take the velocity that it is given? "
        "{}",
        client_.link().name(), watch.sequence, point_text(move.target), point_text(status.actual), client_.link().last_exchange()));
}

MotionEnd ModbusMotion::run(const ModbusStatus& before, const ArmedMove& move, const StopToken& stop) {
    Watch watch{.before = before,
                .previous = before.sequence,
                .shows_quick_stop = before.has(cia402::kQuickStopInactive),
                .lost_answers = client_.lost_answers()};
    send(move, watch);
    while (true) {
        const auto looked_at = clock_.now();
        const ModbusStatus status = status_through_reconnects(watch, stop);
        std::optional<MotionEnd> end = judge(status, move, watch);
        // An axis that another halted would go on when its halt bit falls, too.
        if (!end || end->is_at_target || end->is_stored || end->edges != 0) drop_set_point(status, watch);
        if (end) {
            end->events = std::move(watch.events);
            const std::uint64_t lost = client_.lost_answers() - watch.lost_answers;
            end->events.insert(end->events.end(), lost, DeviceEvent::Kind::repeated_command);
            return *std::move(end);
        }
        if (stop.halt_requested()) throw Stopped(fmt::format("stopped on the way to {} (machine)", point_text(move.target)));
        require_in_time(status, looked_at, move, watch);
        if (const auto next = looked_at + kPoll; clock_.now() < next) clock_.sleep(next - clock_.now());
    }
}

ModbusStatus ModbusMotion::look_after(std::chrono::nanoseconds time) {
    clock_.sleep(time);
    return client_.status();
}

ModbusStatus ModbusMotion::stop() {
    client_.halt(client_.link().options().reconnect_time);
    const auto deadline = clock_.now() + to_nanoseconds(patience_);
    while (true) {
        ModbusStatus status = client_.status();
        if (status.is_standing()) {
            if (!status.is_fault()) return status;
            if (status.fault_code != cia402::kHeartbeatFault) {
                throw DeviceAlarm(status.fault_code,
                                  fmt::format("{}: {}; clear the cause", client_.link().name(), fault_text(status.fault_code)));
            }
            client_.reset_fault();
            return client_.status();
        }
        if (clock_.now() > deadline) {
            throw DeviceTimeout(
                fmt::format("waited for {} to stand still after a halt; the machine may still move: use the emergency stop; {}",
                            client_.link().name(), client_.link().last_exchange()));
        }
        clock_.sleep(kPoll);
    }
}

}  // namespace palpate
