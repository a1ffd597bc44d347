#include "devices/modbus/modbus_device.h"

#include <fmt/format.h>

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
constexpr std::chrono::milliseconds kDisturbance{10};
// The place to rest at is told by where the probe opens.
constexpr double kUntilOpen = std::numeric_limits<double>::infinity();
// mm: a homed machine may stand a little outside of its own limits.
constexpr double kBeyondLimits = 1.0;
// Looks that `check` times.
constexpr int kTimedLooks = 5;
// Of the time that the controller waits for a heartbeat, what a look may take: the rest is for what is not the same each time.
constexpr double kLookShare = 0.9;

std::string milliseconds_text(Seconds time) { return number_text(std::round(1000 * time.count()), " ms"); }

bool is_in_reach(const Box& limits, const Point& p) { return limits.contains(p, kBeyondLimits); }

bool on_grid(const Point& a, const Point& b, double resolution) { return (a - b).cwiseAbs().maxCoeff() < 0.5 * resolution; }

}  // namespace

std::string_view name_of(ModbusDevice::State state) {
    constexpr std::array<std::string_view, 7> kNames{"connecting", "locked", "idle", "moving", "stopping", "fault", "lost"};
    return kNames[static_cast<std::size_t>(state)];
}

std::vector<std::string> ModbusReport::lines() const {
    const auto said = [](bool yes) { return yes ? "yes" : "no"; };
    return {fmt::format("controller: {}, {}, profile {}", identity, link, profile),
            fmt::format("limits: {} to {} (machine)", point_text(limits.min), point_text(limits.max)),
            fmt::format("position: {} (machine)", point_text(position)),
            fmt::format("homed: {}, standing: {}, enabled: {}", said(is_homed), said(is_standing), said(is_enabled)),
            fmt::format("probe: {}", is_probe_closed ? "closed" : "open"),
            fmt::format("answers: {}", timing_text()),
            !is_in_fault ? "no fault" : fault_text(static_cast<std::uint16_t>(fault_code))};
}

std::string ModbusReport::position_problem() const {
    if (is_in_reach(limits, position)) return "";
    return fmt::format(
        "is out of the controller's own limits, {} to {} (machine): is word_order in the profile right, and are address, type and unit of "
        "the positions? Nothing moves",
        point_text(limits.min), point_text(limits.max));
}

std::string ModbusReport::unit_problem() const {
    if (position_unit_mm <= resolution_mm) return "";
    return fmt::format(
        "is coarser than machine.resolution, {}: a target would never be reached; say {} or more there, or give the profile a finer unit",
        number_text(resolution_mm, " mm"), number_text(position_unit_mm));
}

std::string ModbusReport::timing_text() const {
    return fmt::format("a look takes {}, {}; up to {} will do", milliseconds_text(look_time),
                       look_requests == 1 ? "one request" : "two requests", milliseconds_text(kLookShare * heartbeat_limit));
}

std::string ModbusReport::timing_problem() const {
    if (look_time < kLookShare * heartbeat_limit) return "";
    return fmt::format(
        "the controller stops when it hears no heartbeat for {}, so that moves will be cut to pieces: {}make its answers faster, or raise "
        "that time in the controller and heartbeat_limit in the profile",
        milliseconds_text(heartbeat_limit),
        look_requests == 1 ? "" : "let the controller know FC23 and set read_write: true in the profile, which halves it; ");
}

ModbusDevice::ModbusDevice(ModbusDeviceOptions options, Clock& clock, StopToken stop)
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
        throw DeviceError(fmt::format(R"({} calls itself "{}", but the profile {} is for "{}"; give the profile of that controller)",
                                      where(), identity_, options_.profile.name, options_.profile.expected_identity));
    }
    limits_ = client_->limits();
    if (!limits_.is_valid()) {
        throw DeviceError(
            fmt::format("{} tells limits from {} to {}; set them in the controller, or is word_order in the profile not right?", where(),
                        point_text(limits_.min), point_text(limits_.max)));
    }
}

struct ModbusDevice::Ready {
    ModbusStatus status;
    bool is_reconnected = false;
};

ModbusReport ModbusDevice::report() {
    const ModbusStatus status = state_ == State::idle ? resting_status().status : client_->status();
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
            .is_in_fault = status.is_fault(),
            .fault_code = status.is_fault() ? status.fault_code : 0,
            .position_unit_mm = options_.profile[ModbusField::actual_x].unit,
            .resolution_mm = options_.motion.resolution_mm,
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
    throw BadAnswer(fmt::format("{}: the position {} {}", where(), point_text(status.actual), report.position_problem()));
}

// Throws what is in the way of a move, and sets the state that it leaves the device in.
void ModbusDevice::check_ready(const ModbusStatus& status) {
    if (status.is_fault()) {
        state_ = State::locked;
        throw DeviceAlarm(status.fault_code, fmt::format("{}: {}; clear the cause, then recover", where(), fault_text(status.fault_code)));
    }
    if (!status.is_homed) {
        state_ = State::locked;
        throw PositionLost(fmt::format("{} is not homed, so nobody knows where the tool is; home it, then recover", where()));
    }
    check_reach(status);
    if (!status.is_standing()) {
        state_ = State::locked;
        throw BadAnswer(fmt::format("{} moves although nothing was asked of it; stop what else commands it, then recover", where()));
    }
    if (status.is_probe_closed) {
        throw ProbeClosed(fmt::format("the probe is closed before a move, at {} (machine); free it, or look at its cable and its plug",
                                      point_text(status.actual)));
    }
}

// Nothing moves, and a controller may close what nobody used for long.
ModbusDevice::Ready ModbusDevice::resting_status() {
    try {
        return {client_->status(), false};
    } catch (const ConnectionLost&) {
        client_->link().reconnect(stop_);
        return {client_->status(), true};
    }
}

// The status just before a move. A connection that was lost while nothing moved is made again: position and homing tell whether the
// machine is still where it was left.
ModbusDevice::Ready ModbusDevice::ready() {
    if (state_ != State::idle && state_ != State::locked) {
        const std::string what = fmt::format("{} is in the state \"{}\" since an earlier failure; recover first", where(), name_of(state_));
        if (state_ == State::lost) throw ConnectionLost(what);
        throw DeviceError(what);
    }
    Ready ready = resting_status();
    const ModbusStatus status = ready.status;
    check_ready(status);
    if (state_ == State::locked) throw DeviceError(fmt::format("{} was locked and is free now; recover before it moves", where()));
    if (const Point expected = position_ + options_.origin; !motion_->is_near(status.actual, expected)) {
        state_ = State::locked;
        throw PositionLost(
            fmt::format("{} was left at {} (machine) and stands at {} now: it was moved by something else; make sure of its position, then "
                        "recover",
                        where(), point_text(expected), point_text(status.actual)));
    }
    shows_quick_stop_ = shows_quick_stop_ || status.has(cia402::kQuickStopInactive);
    if (shows_quick_stop_ && !status.has(cia402::kQuickStopInactive)) {
        // The next command would lead out of it.
        state_ = State::locked;
        throw DeviceAlarm(0, fmt::format("{}: it is in a quick stop, by somebody else; clear the cause, then recover", where()));
    }
    const bool is_new = !was_enabled_ || ready.is_reconnected;
    if (!status.has(cia402::kOperationEnabled)) {
        if (was_enabled_) {
            state_ = State::locked;
            throw DeviceAlarm(
                0, fmt::format("{}: its drives are disabled, by an emergency stop perhaps; clear the cause, then recover", where()));
        }
        client_->enable();
    } else if (is_new) {
        // An earlier host may have left the set-point bit set, and a controller takes a command at its rising edge.
        client_->take_back_set_point();
        ready.status = client_->status();
    }
    was_enabled_ = true;
    return ready;
}

void ModbusDevice::check_target(const Point& machine) const {
    if (!machine.allFinite()) throw DeviceError("the target of a move is not finite; give three numbers in mm");
    if (!limits_.contains(machine)) {
        throw OutOfLimits(fmt::format("a move to {} leaves the limits of {}, {} to {} (machine coordinates); nothing was sent",
                                      point_text(machine), where(), point_text(limits_.min), point_text(limits_.max)));
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
    if (stop_.halt_requested()) throw Stopped(fmt::format("stopped before the move to {}; nothing moved", point_text(target)));
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
        throw Stopped(fmt::format("stopped by the operator; the tool went back to {} and rests there", point_text(position_)));
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
    const std::string on_the_way = fmt::format("on the way to {} (machine)", point_text(way.target));
    if (end.edges == 0 && !end.is_stored) {
        if (end.status.is_probe_closed) throw BadAnswer(fmt::format("the probe is closed, but no touch was latched {}", on_the_way));
        if (!end.is_at_target) {
            throw DeviceAlarm(
                0, fmt::format("{} stopped at {} {} and latched no touch: somebody halted it, or the probe closed for a moment; nothing "
                               "more was sent to it; look at it, then recover",
                               where(), point_text(end.status.actual), on_the_way));
        }
        return result;
    }
    if (end.edges != 1 || !end.is_stored) {
        throw BadAnswer(fmt::format("{} counted {} touches {} and latched {}; a touch was missed or repeated: does the probe bounce?",
                                    where(), end.edges, on_the_way, end.is_stored ? "one" : "none"));
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
        throw BadAnswer(
            fmt::format("{} latched a touch at {}, {:f} mm off the way from {} to {} (machine): is it the latch of an earlier move?",
                        where(), point_text(status.latched), off, point_text(way.start), point_text(way.target)));
    }
}

// A tool that ran on farther than the probe gives way presses on it. Where the probe is open it has not: that is no place of its.
void ModbusDevice::check_run_on(const ModbusStatus& status, const Way& way) {
    const double ran_on = way.place_of(status.actual) - way.place_of(status.latched);
    const bool is_too_far = ran_on > options_.motion.overtravel_mm + motion_->tolerance();
    if (ran_on < -motion_->tolerance() || (is_too_far && !status.is_probe_closed)) {
        motion_->refuse(status, fmt::format("{} says that the tool is at {}, {:f} mm {} the touch at {} (machine){}", where(),
                                            point_text(status.actual), std::abs(ran_on), is_too_far ? "behind" : "before",
                                            point_text(status.latched), is_too_far ? " with the probe open" : ""));
    }
    if (is_too_far) {
        throw BadAnswer(
            fmt::format("{} ran on by {:f} mm after the touch at {} (machine), more than the probe gives way; look at the probe, and give "
                        "the true acceleration and latency",
                        where(), ran_on, point_text(status.latched)));
    }
}

// To a place of the way, at the probing feed.
ModbusStatus ModbusDevice::go(const ModbusStatus& status, const Way& way, double place, ProbeEdge edge) {
    const Point target = place <= 0.0 ? way.start : way.at(place);
    MotionEnd end = motion_->run(status, {way, target, options_.motion.feeds.probe_mm_per_s, edge}, {});
    if (!end.is_at_target && !end.is_stored && end.edges == 0 && !end.status.is_probe_closed) {
        motion_->refuse(end.status, fmt::format("{} says that it stands at {} after a move to {} (machine) that nothing ended", where(),
                                                point_text(end.status.actual), point_text(target)));
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
        if (now.is_probe_closed) {
            // At the start of the way: a disturbance as short as that was no touch. Wherever it was to rest, it rests there.
            now = motion_->look_after(kDisturbance);
            rest = 0.0;
            if (now.is_probe_closed) continue;
        }
        const Point goal = rest <= 0.0 ? way.start : way.at(rest);
        if (!motion_->is_near(now.actual, goal)) now = go(now, way, rest, ProbeEdge::closing);
        if (!now.is_probe_closed && motion_->is_near(now.actual, goal)) {
            position_ = goal - options_.origin;
            return;
        }
    }
    throw ProbeClosed(
        fmt::format("the probe did not open on the way back to {} (machine): the tool may be pressed on, or the probe is stuck; look at "
                    "it, and free it by the machine's own means",
                    point_text(way.start)));
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
        motion_->refuse(status, fmt::format("{} says that the tool is at {}, beside the way from {} to {} (machine)", where(),
                                            point_text(status.actual), point_text(way.start), point_text(way.target)));
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
        throw ProbeClosed(
            fmt::format("stopped by the operator; on the way back to {} the probe touched something, at {}: look what is there before you "
                        "go on",
                        point_text(way.start - options_.origin), point_text(position_)));
    }
    position_ = way.start - options_.origin;
    state_ = State::idle;
}

// Both failures are told: the first is the cause.
void ModbusDevice::back_off_after(const DeviceError& failure, const Way& way) {
    const auto both = [&](const DeviceError& second) {
        return fmt::format("{}; and then backing off failed, so that the tool may be pressed on: {}", failure.what(), second.what());
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
        throw ConnectionLost(fmt::format("cannot stop {}: no connection; its controller stops by itself when it is not heard", where()));
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
        throw BadAnswer(
            fmt::format("{} says that the tool is at {}, {:f} mm off the way back to {} (machine), and the probe is closed: nothing was "
                        "moved, and the tool may be pressed on; bring it off by the machine's own means, then recover",
                        where(), point_text(status.actual), off, point_text(way.start)));
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
