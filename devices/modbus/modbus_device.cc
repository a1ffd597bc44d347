#include "devices/modbus/modbus_device.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "devices/errors.h"
#include "devices/internal/way.h"
#include "devices/modbus/internal/modbus_client.h"
#include "devices/modbus/internal/modbus_motion.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

// A probe that bounces while it opens may close again; more often than this it is stuck.
constexpr int kRetractAttempts = 3;
// The place to rest at is told by where the probe opens.
constexpr double kUntilOpen = std::numeric_limits<double>::infinity();
// mm: a homed machine may stand a little outside of its own limits.
constexpr double kBeyondLimits = 1.0;
// Looks that `check` times.
constexpr int kTimedLooks = 5;
// Of the time that the controller waits for a heartbeat, what a look may take: the rest is for what is not the same each time.
constexpr double kLookShare = 0.9;

std::string milliseconds_text(Seconds time) { return number_text(std::round(1000 * time.count())) + " ms"; }

bool is_in_reach(const Box& limits, const Point& p) { return limits.contains(p, kBeyondLimits); }

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
            "answers: " + timing_text(),
            fault_code == 0 ? "no fault" : fault_text(static_cast<std::uint16_t>(fault_code))};
}

std::string ModbusReport::position_problem() const {
    if (is_in_reach(limits, position)) return "";
    return "is out of the controller's own limits, " + point_text(limits.min) + " to " + point_text(limits.max) +
           " (machine): is word_order in the profile right, and are address, type and unit of the positions? Nothing moves";
}

std::string ModbusReport::timing_text() const {
    return "a look takes " + milliseconds_text(look_time) + ", " + (look_requests == 1 ? "one request" : "two requests") + "; up to " +
           milliseconds_text(kLookShare * heartbeat_limit) + " will do";
}

std::string ModbusReport::timing_problem() const {
    if (look_time < kLookShare * heartbeat_limit) return "";
    return "the controller stops when it hears no heartbeat for " + milliseconds_text(heartbeat_limit) +
           ", so that moves will be cut to pieces: " +
           (look_requests == 1 ? "" : "let the controller know FC23 and set read_write: true in the profile, which halves it; ") +
           "make its answers faster, or raise that time in the controller and heartbeat_limit in the profile";
}

ModbusDevice::ModbusDevice(ModbusDeviceOptions options, Clock& clock, std::stop_token stop)
    : options_(std::move(options)), stop_(std::move(stop)) {
    require_stopping(options_.motion);
    client_ = std::make_unique<ModbusClient>(options_.link, options_.profile, clock);
    motion_ = std::make_unique<ModbusMotion>(*client_, options_.motion, clock, options_.patience);
    inspect();
    const ModbusStatus status = client_->status();
    position_ = status.actual - options_.origin;
    seen_ = status.actual;
    const bool is_ready =
        status.is_homed && !status.is_fault() && status.is_standing() && !status.is_probe_closed && is_in_reach(limits_, status.actual);
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
                          "; set them in the controller, or is word_order in the profile not right?");
    }
}

ModbusReport ModbusDevice::report() {
    const ModbusStatus status = client_->status();
    seen_ = status.actual;
    for (; timed_looks_ < kTimedLooks; ++timed_looks_) slowest_look_ = std::max(slowest_look_, client_->look());
    return {.link = where(),
            .profile = options_.profile.name,
            .identity = identity_,
            .limits = limits_,
            .position = status.actual,
            .is_homed = status.is_homed,
            .is_standing = status.is_standing(),
            .is_enabled = status.has(cia402::kOperationEnabled),
            .is_probe_closed = status.is_probe_closed,
            .fault_code = status.is_fault() ? status.fault_code : 0,
            .look_time = slowest_look_,
            .look_requests = client_->look_requests(),
            .heartbeat_limit = options_.profile.heartbeat_limit};
}

// A position that the machine cannot have leads to no motion.
void ModbusDevice::check_reach(const ModbusStatus& status) {
    if (is_in_reach(limits_, status.actual)) return;
    state_ = State::locked;
    ModbusReport report;
    report.limits = limits_;
    report.position = status.actual;
    throw BadAnswer(where() + ": the position " + point_text(status.actual) + " " + report.position_problem());
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
    check_reach(status);
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
        client_->link().reconnect(stop_);
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
    if (!status.has(cia402::kOperationEnabled)) {
        if (was_enabled_) {
            state_ = State::locked;
            throw DeviceAlarm(0, where() + ": its drives are disabled, by an emergency stop perhaps; clear the cause, then recover");
        }
        client_->enable();
    }
    was_enabled_ = true;
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
    } catch (const DeviceAlarm&) {
        // Somebody else has the machine: it is left alone.
        if (state_ == State::moving || state_ == State::stopping) state_ = State::fault;
        throw;
    } catch (const FalseReport&) {
        state_ = State::fault;
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
        client_->halt(Seconds(0));
    } catch (const DeviceError&) {
        return;
    }
}

MoveResult ModbusDevice::move(const Point& target, Pace pace) {
    const Point start = position_ + options_.origin;
    const Point goal = target + options_.origin;
    check_target(goal);
    if (stop_.stop_requested()) throw Stopped("stopped before the move to " + point_text(target) + "; nothing moved");
    if (on_grid(start, goal, options_.motion.resolution_mm) && state_ == State::idle) {
        position_ = target;
        return {MoveResult::Outcome::reached, target};
    }
    const Ready before = ready();
    state_ = State::moving;
    const Way way(start, goal);
    way_back_ = std::make_unique<Way>(way);
    MoveResult result;
    try {
        result = finish(motion_->run(before.status, {way, goal, options_.motion.feeds.of(pace), ProbeEdge::closing}, stop_), way);
    } catch (const ConnectionLost&) {
        throw;
    } catch (const DeviceAlarm&) {
        throw;
    } catch (const PositionLost&) {
        throw;
    } catch (const ProbeClosed&) {
        throw;
    } catch (const FalseReport&) {
        throw;
    } catch (const Stopped&) {
        go_back(way);
        throw Stopped("stopped by the operator; the tool went back to " + point_text(position_) + " and rests there");
    } catch (const DeviceError& failure) {
        back_off_after(failure, way);
        throw;
    }
    if (result.outcome == MoveResult::Outcome::reached) result.position = position_ = target;
    if (before.is_reconnected) result.events.insert(result.events.begin(), {DeviceEvent::Kind::reconnected, start - options_.origin});
    way_back_.reset();
    state_ = State::idle;
    return result;
}

// What a move that ended by itself has found; after a touch, back off.
MoveResult ModbusDevice::finish(const MotionEnd& end, const Way& way) {
    MoveResult result;
    for (const DeviceEvent::Kind kind : end.events) result.events.push_back({kind, end.status.actual - options_.origin});
    const std::string on_the_way = " on the way to " + point_text(way.target) + " (machine)";
    if (end.edges == 0 && !end.is_stored) {
        if (end.status.is_probe_closed) throw BadAnswer("the probe is closed, but no touch was latched" + on_the_way);
        if (!end.is_at_target) {
            throw DeviceAlarm(0,
                              where() + " stopped at " + point_text(end.status.actual) + on_the_way +
                                  " and latched no touch: somebody halted it, or the probe closed for a moment; nothing more was sent to "
                                  "it; look at it, then recover");
        }
        return result;
    }
    if (end.edges != 1 || !end.is_stored) {
        throw BadAnswer(where() + " counted " + std::to_string(end.edges) + " touches" + on_the_way + " and latched " +
                        (end.is_stored ? "one" : "none") + "; a touch was missed or repeated: does the probe bounce?");
    }
    check_contact(end.status, way);
    check_run_on(end.status, way);
    state_ = State::stopping;
    draw_back(end.status, way, way.place_of(end.status.latched) - options_.motion.retract_mm);
    result.outcome = MoveResult::Outcome::contact;
    result.position = end.status.latched - options_.origin;
    return result;
}

void ModbusDevice::check_contact(const ModbusStatus& status, const Way& way) const {
    if (const double off = way.distance_to(status.latched); off > motion_->tolerance()) {
        throw BadAnswer(where() + " latched a touch at " + point_text(status.latched) + ", " + std::to_string(off) +
                        " mm off the way from " + point_text(way.start) + " to " + point_text(way.target) +
                        " (machine): is it the latch of an earlier move?");
    }
}

// A tool that ran on farther than the probe gives way presses on it. Where the probe is open it has not: that is no place of its.
void ModbusDevice::check_run_on(const ModbusStatus& status, const Way& way) {
    const double ran_on = way.place_of(status.actual) - way.place_of(status.latched);
    const bool is_too_far = ran_on > options_.motion.overtravel_mm + motion_->tolerance();
    if (ran_on < -motion_->tolerance() || (is_too_far && !status.is_probe_closed)) {
        motion_->refuse(status, where() + " says that the tool is at " + point_text(status.actual) + ", " +
                                    std::to_string(std::abs(ran_on)) + " mm " + (is_too_far ? "behind" : "before") + " the touch at " +
                                    point_text(status.latched) + " (machine)" + (is_too_far ? " with the probe open" : ""));
    }
    if (is_too_far) {
        throw BadAnswer(where() + " ran on by " + std::to_string(ran_on) + " mm after the touch at " + point_text(status.latched) +
                        " (machine), more than the probe gives way; look at the probe, and give the true acceleration and latency");
    }
}

// To a place of the way, at the probing feed.
ModbusStatus ModbusDevice::go(const ModbusStatus& status, const Way& way, double place, ProbeEdge edge) {
    const Point target = place <= 0.0 ? way.start : way.at(place);
    MotionEnd end = motion_->run(status, {way, target, options_.motion.feeds.probe_mm_per_s, edge}, {});
    if (!end.is_at_target && !end.is_stored && end.edges == 0 && !end.status.is_probe_closed) {
        motion_->refuse(end.status, where() + " says that it stands at " + point_text(end.status.actual) + " after a move to " +
                                        point_text(target) + " (machine) that nothing ended");
    }
    return end.status;
}

// Towards the start until the probe opens: to the place `rest`, and where that is not enough on to the start. Then it rests a retract
// beyond where it opened.
ModbusStatus ModbusDevice::until_open(const ModbusStatus& status, const Way& way, double& rest) {
    ModbusStatus now = status;
    // Never deeper.
    if (rest > 0.0 && rest < way.place_of(now.actual)) now = go(now, way, rest, ProbeEdge::opening);
    if (!now.is_probe_closed) return now;
    if (!motion_->is_near(now.actual, way.start)) now = go(now, way, 0.0, ProbeEdge::opening);
    if (now.is_probe_closed) return now;
    const bool is_latched = (now.touch_status & cia402::kNegativeEdgeStored) != 0 && way.distance_to(now.latched) <= motion_->tolerance();
    rest = is_latched ? std::min(rest, way.place_of(now.latched) - options_.motion.retract_mm) : 0.0;
    return now;
}

// After a touch or a stop: back along the way that the tool came, first until the probe opens, then guarded. `rest` is the place of the way
// where it comes to rest, if the probe is open there; 0 or less: its start.
void ModbusDevice::draw_back(const ModbusStatus& status, const Way& way, double rest) {
    ModbusStatus now = status;
    for (int attempt = 0; attempt < kRetractAttempts; ++attempt) {
        if (now.is_probe_closed) now = until_open(now, way, rest);
        if (now.is_probe_closed) break;
        const Point goal = rest <= 0.0 ? way.start : way.at(rest);
        if (!motion_->is_near(now.actual, goal)) now = go(now, way, rest, ProbeEdge::closing);
        if (!now.is_probe_closed && motion_->is_near(now.actual, goal)) {
            position_ = goal - options_.origin;
            return;
        }
    }
    throw ProbeClosed("the probe did not open on the way back to " + point_text(way.start) +
                      " (machine): the tool may be pressed on, or the probe is stuck; look at it, and free it by the machine's own means");
}

// Stops a move that failed and leaves the device idle with the probe open; if it throws, the device is in fault. Where the probe is
// pressed, nothing is reckoned from where the tool is said to be.
void ModbusDevice::back_off(const Way& way) {
    state_ = State::stopping;
    const ModbusStatus status = motion_->stop();
    motion_->require_ours(status);
    if (status.is_probe_closed) {
        draw_back(status, way, kUntilOpen);
    } else if (way.distance_to(status.actual) <= motion_->tolerance()) {
        draw_back(status, way, way.place_of(status.actual) - options_.motion.retract_mm);
    } else {
        motion_->refuse(status, where() + " says that the tool is at " + point_text(status.actual) + ", beside the way from " +
                                    point_text(way.start) + " to " + point_text(way.target) + " (machine)");
    }
    way_back_.reset();
    state_ = State::idle;
}

// The whole way that a move had come.
void ModbusDevice::go_back(const Way& way) {
    back_off(way);
    const ModbusStatus status = client_->status();
    if (motion_->is_near(status.actual, way.start)) return;
    state_ = State::stopping;
    const ModbusStatus end = go(status, way, 0.0, ProbeEdge::closing);
    position_ = end.actual - options_.origin;
    if (end.is_probe_closed || !motion_->is_near(end.actual, way.start)) {
        throw ProbeClosed("stopped by the operator; on the way back to " + point_text(way.start - options_.origin) +
                          " the probe touched something, at " + point_text(position_) + ": look what is there before you go on");
    }
    position_ = way.start - options_.origin;
    state_ = State::idle;
}

// Both failures are told: the first is the cause.
void ModbusDevice::back_off_after(const DeviceError& failure, const Way& way) {
    const auto both = [&](const DeviceError& second) {
        return std::string(failure.what()) + "; and then backing off failed, so that the tool may be pressed on: " + second.what();
    };
    try {
        back_off(way);
    } catch (const ConnectionLost& second) {
        throw ConnectionLost(both(second));
    } catch (const DeviceAlarm& second) {
        throw DeviceAlarm(second.code(), both(second));
    } catch (const FalseReport& second) {
        throw FalseReport(both(second));
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
    const Point end = start + options_.origin;
    way_back_ = motion_->is_near(seen_, end) ? nullptr : std::make_unique<Way>(end, seen_);
    recover();
}

// Off the surface on which a move that failed, or an earlier host, has left the tool.
void ModbusDevice::leave_surface(const ModbusStatus& status) {
    const Way way = *way_back_;
    if (const double off = way.distance_to(status.actual); off > motion_->tolerance()) {
        throw BadAnswer(where() + " says that the tool is at " + point_text(status.actual) + ", " + std::to_string(off) +
                        " mm off the way back to " + point_text(way.start) +
                        " (machine), and the probe is closed: nothing was moved, and the tool may be pressed on; bring it off by the "
                        "machine's own means, then recover");
    }
    if (!status.has(cia402::kOperationEnabled)) client_->enable();
    state_ = State::stopping;
    draw_back(client_->status(), way, kUntilOpen);
    state_ = State::connecting;
}

void ModbusDevice::recover() {
    if (!client_->link().is_connected()) client_->link().reconnect(stop_);
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
            check_reach(status);
            leave_surface(status);
            status = client_->status();
        }
        check_ready(status);
        position_ = status.actual - options_.origin;
        way_back_.reset();
        was_enabled_ = false;
        state_ = State::idle;
    } catch (const ConnectionLost&) {
        if (state_ == State::stopping) halt_after_failure();
        state_ = client_->link().is_connected() ? State::fault : State::lost;
        throw;
    } catch (const DeviceAlarm&) {
        state_ = State::locked;
        throw;
    } catch (const FalseReport&) {
        state_ = State::locked;
        throw;
    } catch (const DeviceError&) {
        if (state_ == State::stopping) halt_after_failure();
        state_ = State::locked;
        throw;
    }
}

}  // namespace palpate
