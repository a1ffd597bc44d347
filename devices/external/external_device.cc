#include "devices/external/external_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "devices/errors.h"
#include "devices/external/internal/external_talk.h"
#include "devices/internal/way.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

using namespace std::chrono_literals;

// From one sign of life to the next, of both sides.
constexpr auto kAlive = 100ms;
// What a move may take beyond its duration as it is reckoned.
constexpr double kPatience = 2.0;
constexpr auto kMoreTime = 5s;
// The longest homing cycle of a large, slow machine.
constexpr auto kHomingTime = 300s;
// mm: so far beside its way a tool that is under way may be seen: axes are not read at one instant.
constexpr double kOffWay = 0.1;
// Both ends and the touch are rounded.
constexpr double kRoundings = 3.0;
// A probe that bounces while it opens may close again; more often than this it is stuck.
constexpr int kBounces = 20;
// A contact that bounces, or a spark on its lead, is over by then.
constexpr auto kSettling = 500ms;
// Of an answer that cannot be true, where nothing was sent to free the tool.
constexpr const char* kMayBePressed = "; it may be pressed against what it touched: look, and free it by hand";

}  // namespace

struct ExternalDevice::End {
    enum class By { target, probe, stop };
    By by = By::target;
    std::optional<Point> touched;  // mm, machine coordinates
    Point rest = Point::Zero();
    bool is_probe_closed = false;
    std::string why{};  // it was stopped
};

// Over what the program does, until it answers.
struct ExternalDevice::Watch {
    std::chrono::nanoseconds heard;
    std::chrono::nanoseconds next_sign = heard + kAlive;
};

ExternalDevice::ExternalDevice(ByteStream& stream, Clock& clock, const ExternalOptions& options, StopToken stop)
    : options_(options),
      stop_(std::move(stop)),
      talk_(std::make_unique<external::Talk>(stream, clock, to_nanoseconds(options.slowest_answer))) {
    require_stopping(options_.motion);
    greet();
    position_ = state().position;
}

ExternalDevice::~ExternalDevice() = default;

std::string ExternalDevice::name() const { return talk_->name(); }

double ExternalDevice::tolerance() const { return kRoundings * std::max(options_.motion.resolution_mm, hello_.resolution_mm); }

void ExternalDevice::lose(const std::string& what) {
    is_lost_ = true;
    // Before it is greeted nothing has moved.
    talk_->refuse(hello_.name.empty() ? what : what + kMayBePressed);
}

// --- asking ----------------------------------------------------------------------------------------------------------

void ExternalDevice::greet() {
    const external::Line line = talk_->ask_hello(options_.silence.count(), to_nanoseconds(options_.start_time));
    if (!line.name || !line.limits || !line.feed || !line.acceleration || !line.resolution || !line.stops_at_touch || !line.latches) {
        lose("answers \"hello\" without all of name, limits, feed, acceleration, resolution, stops_at_touch and latches");
    }
    hello_ = {*line.name,
              *line.limits,
              *line.feed,
              *line.acceleration,
              *line.resolution,
              Seconds(line.latch_time.value_or(0)),
              line.homes.value_or(false)};
    if (!hello_.limits.is_valid() || !(hello_.feed_mm_per_s > 0) || !(hello_.acceleration_mm_per_s2 > 0) || !(hello_.resolution_mm > 0) ||
        hello_.latch_time < Seconds(0)) {
        lose("says limits, a feed, an acceleration, a resolution or a latch_time that no machine has");
    }
    const char* const missing = !*line.stops_at_touch ? "does not stop by itself at a touch (stops_at_touch)"
                                : !*line.latches      ? "does not know where it touched, only where it came to rest (latches)"
                                                      : nullptr;
    if (missing == nullptr) return;
    is_lost_ = true;
    throw DeviceError(fmt::format("{} on {} {}: that is not safe to probe with, and nothing moves", hello_.name, name(), missing));
}

ExternalState ExternalDevice::state() {
    const external::Line line = talk_->ask("state");
    if (!line.position || !line.moving || !line.probe_closed || !line.homed || !line.fault) {
        lose("answers \"state\" without all of position, moving, probe, homed and fault");
    }
    return {*line.position, *line.moving, *line.probe_closed, *line.homed, *line.fault};
}

void ExternalDevice::require_able(const ExternalState& state) const {
    std::string problem;
    if (!state.fault.empty()) {
        problem = fmt::format("has a fault: {}", state.fault);
    } else if (!state.is_homed) {
        problem = fmt::format("is not homed, so nobody knows where the tool is: home it{}",
                              hello_.homes ? ", or let Palpate do so (machine.homing: run)" : " by its own means");
    } else if (state.is_moving) {
        problem = "moves, and not by Palpate";
    }
    if (!problem.empty()) throw DeviceAlarm(0, fmt::format("{} on {} {}; nothing was sent", hello_.name, name(), problem));
}

ExternalState ExternalDevice::ready_at(const Point& start) {
    ExternalState state = this->state();
    try {
        require_able(state);
    } catch (const DeviceAlarm&) {
        is_lost_ = true;
        throw;
    }
    if ((state.position - start).norm() > tolerance()) {
        lose(fmt::format("says that it is at {} (machine), where it had come to rest at {}: was it moved by something else?",
                         point_text(state.position), point_text(start)));
    }
    return state;
}

void ExternalDevice::make_ready() {
    ExternalState state = this->state();
    if (options_.homing == Homing::run && hello_.homes && !state.is_homed && !state.is_moving && state.fault.empty()) {
        home();
        state = this->state();
    }
    require_able(state);
    if (state.is_probe_closed) {
        throw ProbeClosed(
            fmt::format("the probe of {} on {} is closed before anything moves: does it touch something?", hello_.name, name()));
    }
    // devices/FACTS.md, "Safety floor": what the stopping distance was computed with has to be true.
    if (hello_.acceleration_mm_per_s2 < options_.motion.acceleration_mm_per_s2) {
        throw DeviceError(
            fmt::format("{} on {} accelerates with {} at the most, less than machine.acceleration, {}: it would run on too far after a "
                        "touch; lower machine.acceleration to that",
                        hello_.name, name(), number_text(hello_.acceleration_mm_per_s2, " mm/s²"),
                        number_text(options_.motion.acceleration_mm_per_s2, " mm/s²")));
    }
    if (hello_.resolution_mm > options_.motion.resolution_mm) {
        throw DeviceError(fmt::format("{} on {} tells positions to {}, coarser than machine.resolution, {}: say that there", hello_.name,
                                      name(), number_text(hello_.resolution_mm, " mm"), number_text(options_.motion.resolution_mm, " mm")));
    }
    position_ = state.position;
}

std::optional<external::Line> ExternalDevice::listen(Watch& watch, std::uint64_t id) {
    auto line = talk_->receive(watch.next_sign);
    const auto now = talk_->now();
    if (now >= watch.next_sign) {
        talk_->say_alive();
        watch.next_sign = now + kAlive;
    }
    if (line) watch.heard = now;
    if (line && line->id && *line->id != id) lose(fmt::format("answers question {}, not {}", *line->id, id));
    return line;
}

bool ExternalDevice::is_silent(const Watch& watch) const { return talk_->now() - watch.heard > to_nanoseconds(options_.silence); }

void ExternalDevice::home() {
    if (stop_.stop_requested()) throw Stopped("stopped before homing; nothing has moved");
    const std::uint64_t id = talk_->send([](std::uint64_t number) { return external::ask(number, "home"); });
    const auto until = talk_->now() + kHomingTime;
    Watch watch{talk_->now()};
    while (talk_->now() < until) {
        if (stop_.stop_requested()) {
            ask_to_stop();
            throw PositionLost(fmt::format("homing {} on {} was stopped by the operator: home again, then resume", hello_.name, name()));
        }
        const auto line = listen(watch, id);
        if (line && line->id) {
            if (line->error)
                throw DeviceAlarm(0, fmt::format("{} on {} was not homed: {}{}", hello_.name, name(), *line->error, talk_->history()));
            return;
        }
        if (is_silent(watch)) break;
    }
    ask_to_stop();
    talk_->fail_silent("the end of homing, which was told to stop");
}

// --- moving ----------------------------------------------------------------------------------------------------------

MoveResult ExternalDevice::guarded_move(const Point& target, Pace pace) {
    if (stop_.halt_requested()) throw Stopped(fmt::format("stopped before a move; the tool rests at {}", point_text(position())));
    if (is_lost_) throw PositionLost(fmt::format("nothing moves on {} after its last fault before a new connection", name()));
    if (!target.allFinite()) {
        throw DeviceError(fmt::format("the target {} of a move is not finite: give three numbers in mm", point_text(target)));
    }
    const Point goal = rounded(options_.motion, target + options_.origin);
    if (!hello_.limits.contains(goal, tolerance())) {
        throw OutOfLimits(fmt::format("the target {} lies beyond the limits of {}, {} to {} (machine): nothing was sent", point_text(goal),
                                      hello_.name, point_text(hello_.limits.min), point_text(hello_.limits.max)));
    }
    const Point start = position_;
    if (is_at(goal)) return {MoveResult::Outcome::reached, target};
    if (ready_at(start).is_probe_closed) {
        throw ProbeClosed(fmt::format("the probe of {} on {} is closed where a move begins, at {}: nothing was sent; free it", hello_.name,
                                      name(), point_text(position())));
    }
    const End end = run({start, goal}, pace, false, OnStop::go_back);
    position_ = end.rest;
    MoveResult result;
    result.position = end.touched ? Point(*end.touched - options_.origin) : target;
    if (!end.touched) {
        position_ = goal;
        if (!end.is_probe_closed) return result;
        back_off(goal, start, true);
        lose("reports no contact and a closed probe at the end of a move: it was not ended by it, and was taken back until it opened");
    }
    result.outcome = MoveResult::Outcome::contact;
    result.held = end.is_probe_closed;
    const double overrun = (end.rest - *end.touched).norm();
    back_off(*end.touched, start, end.is_probe_closed);
    if (overrun > options_.motion.overtravel_mm) {
        is_lost_ = true;
        throw DeviceError(fmt::format(
            "{} on {} ran on {:g} mm past a touch, more than the probe's overtravel of {:g} mm: lower machine.feeds, or correct "
            "machine.acceleration and machine.latency{}",
            hello_.name, name(), overrun, options_.motion.overtravel_mm, talk_->history()));
    }
    return result;
}

void ExternalDevice::ask_to_stop() noexcept {
    is_lost_ = true;
    try {
        (void)talk_->send([](std::uint64_t id) { return external::ask(id, "stop"); });
    } catch (const DeviceError&) {
        // It is gone, and stops by itself.
    }
}

ExternalDevice::End ExternalDevice::run(const Way& way, Pace pace, bool until_open, OnStop on_stop) {
    const double feed = std::min(options_.motion.feeds.of(pace), hello_.feed_mm_per_s);
    const double acceleration = std::min(options_.motion.acceleration_mm_per_s2, hello_.acceleration_mm_per_s2);
    const external::Move move{pace == Pace::travel, way.target, feed, acceleration, until_open};
    try {
        const std::uint64_t id = talk_->send([&](std::uint64_t number) { return external::ask_move(number, move); });
        End end = wait_for_end(way, id, feed, on_stop);
        check(end, way, feed);
        return end;
    } catch (const BadAnswer&) {
        ask_to_stop();
        throw;
    } catch (const ConnectionLost&) {
        is_lost_ = true;
        throw;
    }
}

ExternalDevice::End ExternalDevice::wait_for_end(const Way& way, std::uint64_t move, double feed_mm_per_s, OnStop on_stop) {
    const auto longest = to_nanoseconds(kPatience * move_duration(options_.motion, way.length, feed_mm_per_s)) + kMoreTime;
    const auto begun = talk_->now();
    Watch watch{begun};
    while (true) {
        const bool halts = on_stop == OnStop::go_back ? stop_.halt_requested() : on_stop == OnStop::stay && stop_.stop_requested();
        if (halts) {
            const End end = stop_move(way, move);
            if (on_stop == OnStop::go_back) go_back_and_throw(way, end);
            position_ = end.rest;
            throw Stopped(fmt::format("stopped by the operator; the tool rests at {}", point_text(position())));
        }
        const auto line = listen(watch, move);
        if (line && line->id) {
            if (!line->error) return to_end(*line);
            fail_refused(way, *line->error);
        }
        if (line && !line->position) lose("gives a sign of life without its position in a move");
        if (line) check_seen(way, *line->position);
        if (talk_->now() - begun > longest) {
            ask_to_stop();
            throw DeviceTimeout(fmt::format("a move of {} on {} took far longer than its feed explains and was told to stop{}", hello_.name,
                                            name(), talk_->history()));
        }
        if (is_silent(watch)) {
            ask_to_stop();
            talk_->fail_silent("a sign of life in a move, which was told to stop");
        }
    }
}

// That nothing has moved is looked at: what fails in mid-move may say so by an error, too.
void ExternalDevice::fail_refused(const Way& way, const std::string& why) {
    const ExternalState state = this->state();
    const bool has_moved = state.is_moving || !state.fault.empty() || (state.position - way.start).norm() > tolerance();
    const std::string text = fmt::format("{} on {} refuses a move: {}", hello_.name, name(), why);
    if (!has_moved) throw DeviceRefused(0, text + talk_->history());
    ask_to_stop();
    throw DeviceAlarm(0, fmt::format("{}; it is at {} (machine) and was told to stop{}{}", text, point_text(state.position), kMayBePressed,
                                     talk_->history()));
}

ExternalDevice::End ExternalDevice::run_off(const Way& way, bool until_open) {
    try {
        return run(way, Pace::probe, until_open, OnStop::finish);
    } catch (const DeviceRefused&) {
        const ExternalState state = ready_at(way.start);
        if (state.is_probe_closed != until_open) return {End::By::stop, {}, way.start, state.is_probe_closed};
        is_lost_ = true;
        throw;
    }
}

ExternalDevice::End ExternalDevice::stop_move(const Way& way, std::uint64_t move) {
    const std::uint64_t stop = talk_->send([](std::uint64_t id) { return external::ask(id, "stop"); });
    const auto until = talk_->now() + talk_->answer_time() + kMoreTime;
    std::optional<End> end;
    while (talk_->now() < until) {
        const auto line = talk_->receive(talk_->now() + kAlive);
        talk_->say_alive();
        if (!line || !line->id) continue;
        if (*line->id == move && !end) {
            // One that was refused as the stop came has not begun.
            end = line->error ? End{End::By::stop, {}, way.start, false} : to_end(*line);
        } else if (*line->id == stop && end) {
            if (!line->position || !line->probe_closed) lose("answers \"stop\" without position and probe");
            // It stands now; the move may have been answered before.
            end->rest = *line->position;
            end->is_probe_closed = *line->probe_closed;
            std::string problem;
            if (end->touched) problem = problem_of({end->touched, end->rest}, way, tolerance());
            if (way.distance_to(end->rest) > tolerance())
                problem = fmt::format("rests at {}, which is not on its way", point_text(end->rest));
            if (!problem.empty()) lose("was stopped, and " + problem);
            return *end;
        } else {
            lose(fmt::format("answers question {} while the end of a move and then of a stop are awaited", *line->id));
        }
    }
    is_lost_ = true;
    talk_->fail_silent("the end of a move that it was told to stop");
}

ExternalDevice::End ExternalDevice::to_end(const external::Line& line) {
    using By = End::By;
    if (!line.ended || !line.position || !line.probe_closed) lose("answers a move without all of ended, position and probe");
    End end{By::target, {}, *line.position, *line.probe_closed};
    if (*line.ended == "probe") {
        if (!line.touched) lose("answers a move that the probe ended without touched");
        end.by = By::probe;
        end.touched = line.touched;
    } else if (*line.ended == "stopped") {
        end.by = By::stop;
        end.why = line.why.value_or("");
    } else if (*line.ended != "target") {
        lose(fmt::format("says that a move was ended by \"{}\"; allowed: target, probe, stopped", *line.ended));
    }
    return end;
}

void ExternalDevice::check(const End& end, const Way& way, double feed_mm_per_s) {
    if (end.by == End::By::stop) {
        is_lost_ = true;
        throw DeviceAlarm(0, fmt::format("{} on {} says that it was stopped, and not by Palpate{}{}: see where the tool is, then resume{}",
                                         hello_.name, name(), end.why.empty() ? "" : ", but: ", end.why, talk_->history()));
    }
    const std::string problem = problem_of({end.touched, end.rest}, way, tolerance());
    if (!problem.empty()) lose(fmt::format("{} (move from {} to {})", problem, point_text(way.start), point_text(way.target)));
    if (!end.touched) return;
    const double overrun = (end.rest - *end.touched).norm();
    if (overrun > longest_overrun(options_.motion, feed_mm_per_s, tolerance())) {
        lose(fmt::format("reports that it rests {} mm past where the probe changed: it did not stop for it", number_text(overrun)));
    }
}

void ExternalDevice::check_seen(const Way& way, const Point& reported) {
    if (way.distance_to(reported) <= kOffWay + tolerance()) return;
    lose(fmt::format("is seen at {}, off its way from {} to {}", point_text(reported), point_text(way.start), point_text(way.target)));
}

// --- going back ------------------------------------------------------------------------------------------------------

void ExternalDevice::back_off(const Point& contact, const Point& start, bool is_closed) {
    Point goal = retracted(options_.motion, contact, start);
    for (int bounce = 0; bounce < kBounces; ++bounce) {
        if (is_closed) {
            if (is_at(start)) {
                if (!opens_soon()) break;
                return;
            }
            const End end = run_off({position_, start}, true);
            position_ = end.rest;
            is_closed = end.is_probe_closed;
            if (end.touched) goal = retracted(options_.motion, *end.touched, start);
            continue;
        }
        // Never deeper.
        if (is_at(goal) || (position_ - start).norm() < (goal - start).norm()) return;
        const End end = run_off({position_, goal}, false);
        position_ = end.by == End::By::target ? goal : end.rest;
        is_closed = end.is_probe_closed;
    }
    is_lost_ = true;
    throw ProbeClosed(
        fmt::format("the probe of {} on {} stays closed although the tool went back to {}: the tool is pressed against something, or the "
                    "probe is stuck, bent, or its lead shorted. Free it, then resume{}",
                    hello_.name, name(), point_text(position()), talk_->history()));
}

bool ExternalDevice::opens_soon() {
    const auto until = talk_->now() + kSettling;
    while (talk_->now() < until) {
        if (!state().is_probe_closed) return true;
    }
    return false;
}

void ExternalDevice::go_to(const Point& start, OnStop on_stop) {
    if (is_at(start)) return;
    const End end = run({position_, start}, Pace::probe, false, on_stop);
    position_ = end.touched ? end.rest : start;
    if (!end.touched && !end.is_probe_closed) return;
    is_lost_ = true;
    throw ProbeClosed(fmt::format("on the way back to {} the probe touched something, at {}: look what is there before you go on",
                                  point_text(start - options_.origin), point_text(end.touched.value_or(end.rest) - options_.origin)));
}

void ExternalDevice::go_back_and_throw(const Way& way, const End& end) {
    position_ = end.rest;
    back_off(end.touched.value_or(end.rest), way.start, end.is_probe_closed);
    go_to(way.start);
    throw Stopped(fmt::format("stopped by the operator; the tool went back to {} and rests there", point_text(position())));
}

void ExternalDevice::stop() { (void)talk_->ask("stop"); }

void ExternalDevice::retreat(const Point& target) {
    const Point goal = rounded(options_.motion, target + options_.origin);
    const ExternalState state = this->state();
    require_able(state);
    position_ = state.position;
    for (const Point& p : {goal, position_}) {
        if (hello_.limits.contains(p, tolerance())) continue;
        throw OutOfLimits(fmt::format("{} lies beyond the limits of {}: nothing was sent", point_text(p), hello_.name));
    }
    back_off(position_, goal, state.is_probe_closed);
    go_to(goal, OnStop::stay);
}

}  // namespace palpate
