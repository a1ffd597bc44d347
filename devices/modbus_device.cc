#include "devices/modbus_device.h"

#include <algorithm>
#include <array>
#include <utility>

#include "devices/errors.h"
#include "devices/internal/modbus_client.h"
#include "devices/internal/modbus_motion.h"
#include "devices/trail.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

// mm: axes that follow a slanted line lag behind it by different amounts; a latch farther off belongs to another move.
constexpr double kPathTolerance = 0.05;
// Rounding of the latch, of the start and of the target, each half a resolution per axis: √3 · 3/2.
constexpr double kRoundingResolutions = 2.6;
// A probe that bounces while it opens may close again; more often than this it is stuck.
constexpr int kRetractAttempts = 3;

bool on_grid(const Point& a, const Point& b, double resolution) { return (a - b).cwiseAbs().maxCoeff() < 0.5 * resolution; }

}  // namespace

std::string_view name_of(ModbusDevice::State state) {
    constexpr std::array<std::string_view, 7> kNames{"connecting", "locked", "idle", "moving", "stopping", "fault", "lost"};
    return kNames[static_cast<std::size_t>(state)];
}

std::vector<std::string> ModbusReport::lines() const {
    const auto said = [](bool yes) { return yes ? "yes" : "no"; };
    return {"controller: " + identity + ", " + link + ", profile " + profile,
            "limits: " + point_text(limits.min) + " to " + point_text(limits.max) + " (machine)",
            "position: " + point_text(position) + " (machine)",
            std::string("homed: ") + said(is_homed) + ", standing: " + said(is_standing) + ", enabled: " + said(is_enabled),
            std::string("probe: ") + (is_probe_closed ? "closed" : "open"),
            fault_code == 0 ? "no fault" : fault_text(static_cast<std::uint16_t>(fault_code))};
}

ModbusDevice::ModbusDevice(ModbusDeviceOptions options, Clock& clock, std::stop_token stop)
    : options_(std::move(options)), stop_(std::move(stop)) {
    require_stopping(options_.kinematics);
    client_ = std::make_unique<ModbusClient>(options_.link, options_.profile, clock);
    motion_ = std::make_unique<ModbusMotion>(*client_, options_.kinematics, clock, options_.patience);
    inspect();
    const ModbusStatus status = client_->status();
    position_ = status.actual - options_.origin;
    const bool is_ready = status.is_homed && !status.is_fault() && status.is_standing() && !status.is_probe_closed;
    state_ = is_ready ? State::idle : State::locked;
}

ModbusDevice::~ModbusDevice() = default;

std::string ModbusDevice::where() const { return client_->link().name(); }

// Is it the controller that the profile is for, and what can it reach?
void ModbusDevice::inspect() {
    identity_ = client_->identity();
    if (!identity_.starts_with(options_.profile.expected_identity)) {
        throw DeviceError(where() + " calls itself \"" + identity_ + "\", but the profile " + options_.profile.name + " is for \"" +
                          options_.profile.expected_identity + "\"; give the profile of that controller");
    }
    limits_ = client_->limits();
    if (!limits_.is_valid()) {
        throw DeviceError(where() + " tells limits from " + point_text(limits_.min) + " to " + point_text(limits_.max) +
                          "; set them in the controller");
    }
}

ModbusReport ModbusDevice::report() {
    const ModbusStatus status = client_->status();
    return {.link = where(),
            .profile = options_.profile.name,
            .identity = identity_,
            .limits = limits_,
            .position = status.actual,
            .is_homed = status.is_homed,
            .is_standing = status.is_standing(),
            .is_enabled = status.has(cia402::kOperationEnabled),
            .is_probe_closed = status.is_probe_closed,
            .fault_code = status.is_fault() ? status.fault_code : 0};
}

// Throws what is in the way of a move, and sets the state that it leaves the device in.
void ModbusDevice::check_ready(const ModbusStatus& status) {
    if (status.is_fault()) {
        state_ = State::locked;
        throw DeviceAlarm(status.fault_code, where() + ": " + fault_text(status.fault_code) + "; clear the cause, then recover");
    }
    if (!status.is_homed) {
        state_ = State::locked;
        throw PositionLost(where() + " is not homed, so nobody knows where the tool is; home it, then recover");
    }
    if (!status.is_standing()) {
        state_ = State::locked;
        throw BadAnswer(where() + " moves although nothing was asked of it; stop what else commands it, then recover");
    }
    if (status.is_probe_closed) {
        throw ProbeClosed("the probe is closed before a move, at " + point_text(status.actual) +
                          " (machine); free it, or look at its cable and its plug");
    }
}

struct ModbusDevice::Ready {
    ModbusStatus status;
    bool is_reconnected = false;
};

// The status just before a move. A connection that was lost while nothing moved is made again: position and homing tell whether the
// machine is still where it was left.
ModbusDevice::Ready ModbusDevice::ready() {
    if (state_ != State::idle && state_ != State::locked) {
        const std::string what =
            where() + " is in the state \"" + std::string(name_of(state_)) + "\" since an earlier failure; recover first";
        if (state_ == State::lost) throw ConnectionLost(what);
        throw DeviceError(what);
    }
    Ready ready;
    try {
        ready.status = client_->status();
    } catch (const ConnectionLost&) {
        client_->link().reconnect();
        ready = {client_->status(), true};
    }
    const ModbusStatus& status = ready.status;
    check_ready(status);
    if (state_ == State::locked) throw DeviceError(where() + " was locked and is free now; recover before it moves");
    if (const Point expected = position_ + options_.origin; !motion_->is_near(status.actual, expected)) {
        state_ = State::locked;
        throw PositionLost(where() + " was left at " + point_text(expected) + " (machine) and stands at " + point_text(status.actual) +
                           " now: it was moved by something else; make sure of its position, then recover");
    }
    if (!status.has(cia402::kOperationEnabled)) client_->enable();
    return ready;
}

void ModbusDevice::check_target(const Point& machine) const {
    if (!machine.allFinite()) throw DeviceError("the target of a move is not finite; give three numbers in mm");
    if (!limits_.contains(machine)) {
        throw OutOfLimits("a move to " + point_text(machine) + " leaves the limits of " + where() + ", " + point_text(limits_.min) +
                          " to " + point_text(limits_.max) + " (machine coordinates); nothing was sent");
    }
}

MoveResult ModbusDevice::guarded_move(const Point& target, Pace pace) {
    try {
        return move(target, pace);
    } catch (const ConnectionLost&) {
        halt_after_failure();
        state_ = client_->link().is_connected() ? State::fault : State::lost;
        throw;
    } catch (const DeviceError&) {
        if (state_ == State::moving || state_ == State::stopping) {
            halt_after_failure();
            state_ = State::fault;
        }
        throw;
    }
}

// After a failure that nothing more is known of: the axes may still move. Throws nothing: the failure is told, and a controller that does
// not hear this hears no heartbeat either.
void ModbusDevice::halt_after_failure() {
    if (!client_->link().is_connected()) return;
    try {
        client_->halt();
    } catch (const DeviceError&) {
        return;
    }
}

MoveResult ModbusDevice::move(const Point& target, Pace pace) {
    const Point start = position_ + options_.origin;
    const Point goal = target + options_.origin;
    check_target(goal);
    if (stop_.stop_requested()) throw Stopped("stopped before the move to " + point_text(target) + "; nothing moved");
    if (on_grid(start, goal, options_.kinematics.resolution_mm) && state_ == State::idle) {
        position_ = target;
        return {MoveResult::Outcome::reached, target};
    }
    const Ready before = ready();
    state_ = State::moving;
    way_back_ = start;
    MoveResult result;
    try {
        result = finish(motion_->run(before.status, {goal, options_.kinematics.feeds.of(pace), ProbeEdge::closing}, stop_), start, goal);
    } catch (const ConnectionLost&) {
        throw;
    } catch (const DeviceAlarm&) {
        throw;
    } catch (const PositionLost&) {
        throw;
    } catch (const ProbeClosed&) {
        throw;
    } catch (const Stopped&) {
        go_back(start);
        throw Stopped("stopped by the operator; the tool went back to " + point_text(position_) + " and rests there");
    } catch (const DeviceError& failure) {
        back_off_after(failure, start);
        throw;
    }
    if (result.outcome == MoveResult::Outcome::reached) result.position = position_ = target;
    if (before.is_reconnected) result.events.insert(result.events.begin(), {DeviceEvent::Kind::reconnected, start - options_.origin});
    way_back_.reset();
    state_ = State::idle;
    return result;
}

// What a move that ended by itself has found; after a touch, back off.
MoveResult ModbusDevice::finish(const MotionEnd& end, const Point& start, const Point& target) {
    MoveResult result;
    for (const DeviceEvent::Kind kind : end.events) result.events.push_back({kind, end.status.actual - options_.origin});
    if (end.edges == 0 && !end.is_stored) {
        if (end.status.is_probe_closed)
            throw BadAnswer("the probe is closed, but no touch was latched on the way to " + point_text(target));
        if (!end.is_at_target) {
            throw BadAnswer(where() + " stopped at " + point_text(end.status.actual) + " on the way to " + point_text(target) +
                            " (machine) and latched no touch");
        }
        return result;
    }
    if (end.edges != 1 || !end.is_stored) {
        throw BadAnswer(where() + " counted " + std::to_string(end.edges) + " touches on the way to " + point_text(target) +
                        " (machine) and latched " + (end.is_stored ? "one" : "none") +
                        "; a touch was missed or repeated: does the probe bounce?");
    }
    check_contact(end.status, start, target);
    state_ = State::stopping;
    retract(end.status, start, end.status.latched);
    result.outcome = MoveResult::Outcome::contact;
    result.position = end.status.latched - options_.origin;
    return result;
}

void ModbusDevice::check_contact(const ModbusStatus& status, const Point& start, const Point& target) const {
    const Kinematics& k = options_.kinematics;
    const double tolerance = kPathTolerance + kRoundingResolutions * k.resolution_mm;
    if (const double off = distance_to({start, target}, status.latched); off > tolerance) {
        throw BadAnswer(where() + " latched a touch at " + point_text(status.latched) + ", " + std::to_string(off) +
                        " mm off the way from " + point_text(start) + " to " + point_text(target) +
                        " (machine): is it the latch of an earlier move?");
    }
    if (const double ran_on = (status.actual - status.latched).norm(); ran_on > k.overtravel_mm + tolerance) {
        throw BadAnswer(where() + " ran on by " + std::to_string(ran_on) + " mm after the touch at " + point_text(status.latched) +
                        " (machine), more than the probe gives way; look at the probe, and give the true acceleration and latency");
    }
}

// From a touch or a stop at `from` back towards the start, first until the probe opens, then guarded.
void ModbusDevice::retract(const ModbusStatus& status, const Point& start, const Point& from) {
    const Kinematics& k = options_.kinematics;
    const Vector back = start - from;
    const Point rest = back.norm() > k.retract_mm ? Point(from + k.retract_mm * back.normalized()) : start;
    ModbusStatus now = status;
    for (int attempt = 0; attempt < kRetractAttempts; ++attempt) {
        if (now.is_probe_closed) now = motion_->run(now, {rest, k.feeds.probe_mm_per_s, ProbeEdge::opening}, {}).status;
        if (now.is_probe_closed) break;
        if (!motion_->is_near(now.actual, rest)) now = motion_->run(now, {rest, k.feeds.probe_mm_per_s, ProbeEdge::closing}, {}).status;
        if (!now.is_probe_closed && motion_->is_near(now.actual, rest)) {
            position_ = rest - options_.origin;
            return;
        }
    }
    throw ProbeClosed("the probe did not open on the way back from " + point_text(from) + " to " + point_text(rest) +
                      " (machine): is it stuck, or the retract shorter than it needs to open?");
}

// Stops a move that failed and leaves the device idle a retract away; if it throws, the device is in fault.
void ModbusDevice::back_off(const Point& start) {
    state_ = State::stopping;
    const ModbusStatus status = motion_->stop();
    retract(status, start, status.actual);
    way_back_.reset();
    state_ = State::idle;
}

// The whole way that a move had come.
void ModbusDevice::go_back(const Point& start) {
    back_off(start);
    const ModbusStatus status = client_->status();
    if (motion_->is_near(status.actual, start)) return;
    state_ = State::stopping;
    const ModbusStatus end = motion_->run(status, {start, options_.kinematics.feeds.probe_mm_per_s, ProbeEdge::closing}, {}).status;
    position_ = end.actual - options_.origin;
    if (end.is_probe_closed || !motion_->is_near(end.actual, start)) {
        throw ProbeClosed("stopped by the operator; on the way back to " + point_text(start - options_.origin) +
                          " the probe touched something, at " + point_text(position_) + ": look what is there before you go on");
    }
    position_ = start - options_.origin;
    state_ = State::idle;
}

// Both failures are told: the first is the cause.
void ModbusDevice::back_off_after(const DeviceError& failure, const Point& start) {
    const auto both = [&](const DeviceError& second) {
        return std::string(failure.what()) + "; and then backing off failed: " + second.what();
    };
    try {
        back_off(start);
    } catch (const ConnectionLost& second) {
        throw ConnectionLost(both(second));
    } catch (const DeviceError& second) {
        throw DeviceError(both(second));
    }
}

void ModbusDevice::stop() {
    if (state_ == State::lost)
        throw ConnectionLost("cannot stop " + where() + ": no connection; its controller stops by itself when it is not heard");
    try {
        (void)motion_->stop();
    } catch (const ConnectionLost&) {
        state_ = State::lost;
        throw;
    } catch (const DeviceError&) {
        state_ = State::fault;
        throw;
    }
}

void ModbusDevice::retreat(const Point& start) {
    way_back_ = start + options_.origin;
    recover();
}

void ModbusDevice::recover() {
    if (!client_->link().is_connected()) client_->link().reconnect();
    state_ = State::connecting;
    try {
        inspect();
        ModbusStatus status = client_->status();
        if (status.is_fault()) {
            client_->reset_fault();
            status = client_->status();
        }
        if (!status.is_standing()) status = motion_->stop();
        if (status.is_probe_closed && status.is_homed && !status.is_fault() && status.is_standing() && way_back_) {
            if (!status.has(cia402::kOperationEnabled)) client_->enable();
            state_ = State::stopping;
            retract(status, *way_back_, status.actual);
            state_ = State::connecting;
            status = client_->status();
        }
        check_ready(status);
        position_ = status.actual - options_.origin;
        way_back_.reset();
        state_ = State::idle;
    } catch (const ConnectionLost&) {
        if (state_ == State::stopping) halt_after_failure();
        state_ = client_->link().is_connected() ? State::fault : State::lost;
        throw;
    } catch (const DeviceError&) {
        if (state_ == State::stopping) halt_after_failure();
        state_ = State::locked;
        throw;
    }
}

}  // namespace palpate
