#include "devices/grbl/grbl_device.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "devices/errors.h"
#include "devices/internal/way.h"
#include "devices/motion_model.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

using namespace std::chrono_literals;
using grbl::Place;
using grbl::ProbeReport;

// While a move is under way the machine is asked that often how it is.
constexpr auto kPollInterval = 200ms;
// ... and on the way off a surface, where a move elsewhere than it was told would do harm soon.
constexpr auto kPollIntervalOnSurface = 40ms;
// An answer comes that soon after a move has ended, or is lost.
constexpr auto kAnswerTime = 1500ms;
// What a move may take beyond its duration as it is reckoned: other accelerations, a slow override.
constexpr double kPatience = 2.0;
constexpr auto kMoreTime = 5s;
// A controller has begun to carry out a line by then.
constexpr auto kParsing = 50ms;
// Of a machine that is asked how it is and says nothing.
constexpr auto kSilence = 3s;
// A contact that bounces, or a spark on its lead, is over by then.
constexpr auto kSettling = 500ms;
// A spark that stopped the tool just as it began to move has to be over before the probe is asked whether it holds.
constexpr auto kSpark = 10ms;
// mm: so far beside its way a tool that is under way may be seen; axes are not read at one instant.
constexpr double kOffWay = 0.1;
// A probe that bounces opens and closes a few times within some hundredths; one that is not free after so many steps back is stuck.
constexpr int kMaxBounces = 20;
// An answer may lie beside the way by that many steps or last digits: both ends and the touch are rounded.
constexpr double kRoundings = 3.0;
// Half the diagonal of a cell of steps, in steps: as far may be what a machine reaches from what it was told.
constexpr double kHalfDiagonal = 0.8661;
// mm: the last digit of positions that are reported in millimetres, and in inches.
constexpr double kLastDigit = 0.001;
constexpr double kLastInchDigit = 0.0001;
// %: a feed override that is above makes the tool run on farther than was reckoned.
constexpr int kFullFeed = 100;
// A byte that sets the override may get lost, and a report may be older than it.
constexpr int kOverrideTries = 3;
// Of an answer that cannot be true, where nothing was sent to free the tool.
constexpr const char* kMayBePressed =
    "; nothing was sent to take the tool back, so it may be pressed against what it touched: look, and free it by hand";

// "G21G90G94G38.3N9999999X1.000Y2.000Z3.000F300": every line says its modes itself, so that no older command's can matter. The feed comes
// last and has no decimals: whatever byte of it gets lost on the line, the tool is not faster than it may be. Without the line number a few
// lost bytes would join the G of the guard to the digits of X: G38.3X0.000 to G0.000, or G30.000, which are rapids. No G word is made of
// nines. At most 72 bytes for coordinates of five digits, of the 80 that Grbl takes.
std::string probe_line(const std::string& word, const Point& work, double feed_mm_per_s) {
    const double feed = std::max(1.0, std::floor(feed_mm_per_s * kSecondsPerMinute));
    return fmt::format("G21G90G94{}N9999999X{:.3f}Y{:.3f}Z{:.3f}F{:.0f}", word, work.x(), work.y(), work.z(), feed);
}

}  // namespace

GrblDevice::GrblDevice(ByteStream& stream, Clock& clock, const GrblOptions& options, StopToken stop)
    : controller_(stream, clock, options.delay, options.boot_time), options_(options), stop_(std::move(stop)) {
    require_stopping(options_.motion);
    controller_.connect(stop_);
    position_ = controller_.resting_place().position;
}

void GrblDevice::make_ready() {
    const std::string name = controller_.link().name();
    require_quiet();
    const bool is_locked = controller_.state() == grbl::State::locked;
    const bool is_unhomed = controller_.place().homed == false;
    if (options_.homing == Homing::run && (is_locked || is_unhomed)) {
        controller_.home(stop_);
    } else if (options_.homing == Homing::require && (is_locked || is_unhomed)) {
        throw DeviceAlarm(
            0, fmt::format("the machine on {} is {}: home it, or let Palpate do so (machine.homing: run), or, if it has no switches and "
                           "its position is right, say machine.homing: skip",
                           name, is_locked ? "locked" : "not homed"));
    } else if (is_locked) {
        controller_.unlock();
    }
    const Place place = controller_.resting_place();
    if (place.state != "Idle") {
        throw DeviceAlarm(0, fmt::format("the machine on {} says {}, not Idle: free it, then go on", name, place.state));
    }
    if (place.probe_unplugged) throw ProbeClosed(fmt::format("the probe on {} is not plugged in", name));
    if (place.probe_closed) {
        throw ProbeClosed(
            fmt::format("the probe on {} is closed before anything moves: does it touch something, or is its input inverted ($6)?", name));
    }
    check_acceleration();
    position_ = place.position;
    last_ = controller_.last_probe();
}

// --- what else runs --------------------------------------------------------------------------------------------------

std::string GrblDevice::disturbance(const grbl::Conditions& conditions) const {
    if (conditions.running.empty() && conditions.feed_override.value_or(kFullFeed) <= kFullFeed) return {};
    std::vector<std::string> found;
    const auto runs = [&](char letter) { return conditions.running.find(letter) != std::string::npos; };
    const bool is_laser = controller_.identity().number(grbl::setting::kLaserMode) == 1;
    const char* const spindle = is_laser ? "laser" : "spindle";
    if (runs('S')) found.push_back(fmt::format("the {} is on (M3; M5 ends it)", spindle));
    if (runs('C')) found.push_back(fmt::format("the {} is on (M4; M5 ends it)", spindle));
    if (runs('M')) found.emplace_back("the coolant mist is on (M7; M9 ends it)");
    if (runs('F')) found.emplace_back("the coolant is on (M8; M9 ends it)");
    if (conditions.feed_override.value_or(kFullFeed) > kFullFeed) {
        found.push_back(fmt::format("the feed override is {} % (set it to 100 %)", *conditions.feed_override));
    }
    return fmt::format("{}", fmt::join(found, ", "));
}

std::string GrblDevice::disturbance() const { return disturbance(controller_.conditions()); }

void GrblDevice::require_quiet() {
    controller_.forget_conditions();
    std::string what = disturbance({controller_.active_accessories(), {}});
    for (int k = 0; what.empty() && k < kOverrideTries; ++k) {
        controller_.reset_feed_override();
        if (controller_.feed_override().value_or(kFullFeed) <= kFullFeed) break;
    }
    if (what.empty()) what = disturbance();
    if (!what.empty()) {
        throw DeviceError(fmt::format("nothing has moved: on the machine on {} {}; then go on", controller_.link().name(), what));
    }
    disturbed_.clear();
    is_quiet_ = true;
}

void GrblDevice::refuse_disturbed() {
    if (disturbed_.empty()) disturbed_ = disturbance();
    if (disturbed_.empty()) return;
    controller_.reset_feed_override();
    controller_.give_up();
    throw DeviceError(fmt::format("on the machine on {} {}; the tool rests at {} and nothing more moves: end it, then resume{}",
                                  controller_.link().name(), disturbed_, point_text(position()), controller_.link().history()));
}

void GrblDevice::slow_down_disturbed() {
    const std::string what = disturbance();
    if (what.empty()) return;
    disturbed_ = what;
    if (controller_.conditions().feed_override.value_or(kFullFeed) > kFullFeed) controller_.reset_feed_override();
}

void GrblDevice::stop_disturbed(const Way& way, OnStop on_stop) {
    const std::string what = disturbance();
    // At once: what it takes to stop grows with the square of the feed. Again after the reset, which may have come between.
    controller_.reset_feed_override();
    stop_on(way);
    controller_.reset_feed_override();
    const bool goes_back = on_stop == OnStop::go_back && controller_.feed_override().value_or(kFullFeed) <= kFullFeed;
    if (goes_back) back_off(way.start, way.start, OnStop::finish);
    controller_.give_up();
    throw DeviceError(fmt::format("on the machine on {} {}: the tool was stopped, {} {}{}; end it, then resume{}",
                                  controller_.link().name(), what, goes_back ? "went back to" : "and rests at", point_text(position()),
                                  goes_back ? " and rests there" : "", controller_.link().history()));
}

// devices/FACTS.md, "Safety floor": what the stopping distance was computed with has to be true.
void GrblDevice::check_acceleration() {
    for (int axis = 0; axis < 3; ++axis) {
        const int setting = grbl::setting::kAcceleration + axis;
        const auto admitted = controller_.identity().number(setting);
        if (!admitted || *admitted >= options_.motion.acceleration_mm_per_s2) continue;
        throw DeviceError(
            fmt::format("the machine on {} accelerates an axis with {} mm/s² (${}), less than machine.acceleration, {} mm/s²: it would run "
                        "on too far after a touch; lower machine.acceleration to that",
                        controller_.link().name(), number_text(*admitted), setting, number_text(options_.motion.acceleration_mm_per_s2)));
    }
}

double GrblDevice::step() const {
    double step = options_.motion.resolution_mm;
    for (int axis = 0; axis < 3; ++axis) {
        const auto steps = controller_.identity().number(grbl::setting::kStepsPerMm + axis);
        if (steps && *steps > 0) step = std::max(step, 1 / *steps);
    }
    return step;
}

double GrblDevice::last_digit() const {
    const double unit = controller_.unit_mm();
    return unit == 1.0 ? kLastDigit : kLastInchDigit * unit;
}

double GrblDevice::tolerance() const { return kRoundings * std::max(step(), last_digit()); }

bool GrblDevice::is_at(const Point& target) const {
    const double resolution = options_.motion.resolution_mm;
    const bool is_exact = step() <= resolution && last_digit() <= resolution;
    const double doubt = is_exact ? resolution / 2 : kHalfDiagonal * (step() + last_digit());
    return (target - position_).norm() < doubt;
}

// --- moving ----------------------------------------------------------------------------------------------------------

MoveResult GrblDevice::guarded_move(const Point& target, Pace pace) {
    if (stop_.halt_requested()) throw Stopped(fmt::format("stopped before a move; the tool rests at {}", point_text(position())));
    if (controller_.state() != grbl::State::idle) {
        throw PositionLost(fmt::format("the machine on {} is {} since its last fault: nothing moves before a new connection",
                                       controller_.link().name(), to_string(controller_.state())));
    }
    if (!target.allFinite()) {
        throw DeviceError(fmt::format("the target {} of a move is not finite: give three numbers in mm", point_text(target)));
    }
    const Point start = position_;
    const Point goal = rounded(options_.motion, target + options_.origin);
    refuse_disturbed();
    // Grbl refuses a move to where it is (error:33).
    if (is_at(goal)) return {MoveResult::Outcome::reached, target};
    const double feed = options_.motion.feeds.of(pace);
    const ProbeEnd end = run_probe("G38.3", goal, feed, OnStop::go_back);
    if (end.report.contact) check_again(end, feed);
    position_ = end.place.position;
    MoveResult result;
    result.position = end.report.contact ? Point(end.report.position - options_.origin) : target;
    if (end.repeated) result.events.push_back({DeviceEvent::Kind::repeated_command, result.position});
    if (!end.report.contact) return result;
    result.outcome = MoveResult::Outcome::contact;
    result.held = holds(end, start, feed);
    retract(end.report.position, start, feed);
    return result;
}

GrblDevice::ProbeEnd GrblDevice::run_probe(const std::string& word, const Point& target, double feed_mm_per_s, OnStop on_stop) {
    const Way way(position_, target);
    slow_down_disturbed();
    if (!last_) last_ = controller_.last_probe();
    const Seconds expected = move_duration(options_.motion, way.length, feed_mm_per_s);
    const auto longest = std::chrono::duration_cast<std::chrono::nanoseconds>(kPatience * expected) + kMoreTime + options_.delay;
    for (const bool again : {false, true}) {
        controller_.begin(probe_line(word, target - controller_.work_offset(), feed_mm_per_s));
        std::optional<ProbeEnd> end = wait_for_end(way, longest, on_stop);
        if (!end) end = find_out(way.start, *last_);
        if (!end) continue;
        end->repeated = end->repeated || again;
        check_answer(*end, way, feed_mm_per_s);
        controller_.end();
        last_ = end->report;
        return *end;
    }
    controller_.fail_silent("the answer to a probing move that was sent twice");
}

std::optional<GrblDevice::ProbeEnd> GrblDevice::wait_for_end(const Way& way, std::chrono::nanoseconds longest, OnStop on_stop) {
    const auto now = [&] { return controller_.link().now(); };
    const auto begun = now();
    auto until = begun + longest;
    const auto interval = on_stop == OnStop::go_back ? kPollInterval : kPollIntervalOnSurface;
    // Only one question is under way, unless it or its answer got lost.
    const auto interval_unanswered = interval + options_.delay;
    auto poll = now() + interval;
    auto heard = now();
    std::optional<std::chrono::nanoseconds> unanswered_since;
    std::optional<std::chrono::nanoseconds> stands_since;
    std::optional<ProbeReport> report;
    while (true) {
        // A pause waits for what only has to be finished.
        const bool halts = on_stop == OnStop::go_back ? stop_.halt_requested() : stop_.stop_requested();
        if (halts && on_stop != OnStop::finish) stop_and_throw(way, on_stop);
        if (on_stop == OnStop::finish) {
            slow_down_disturbed();
        } else if (!disturbance().empty()) {
            stop_disturbed(way, on_stop);
        }
        // The operator may have it slower.
        const int feed_override = controller_.conditions().feed_override.value_or(kFullFeed);
        if (feed_override < kFullFeed) until = std::max(until, begun + longest * kFullFeed / feed_override);
        const auto message = controller_.next(poll);
        if (!message) {
            if (unanswered_since && now() - *unanswered_since > kSilence + options_.delay)
                controller_.fail_silent("the end of a probing move");
            // What it says now counts, not that this process may have been stopped for long.
            if (now() > until && heard > until) {
                controller_.stop();
                controller_.give_up();
                throw DeviceTimeout(
                    fmt::format("a probing move on {} took far longer than its feed explains and was stopped: is an override active, is "
                                "machine.acceleration right?{}",
                                controller_.link().name(), controller_.link().history()));
            }
            controller_.link().send_realtime(grbl::kAskStatus);
            if (!unanswered_since) unanswered_since = now();
            poll = now() + interval_unanswered;
            continue;
        }
        heard = now();
        if (unanswered_since && std::holds_alternative<grbl::Status>(*message)) poll = std::min(poll, heard + interval);
        unanswered_since.reset();
        if (const auto* error = std::get_if<grbl::Error>(&*message)) controller_.fail(*error);
        if (const auto* seen = std::get_if<ProbeReport>(&*message)) {
            report = ProbeReport{controller_.unit_mm() * seen->position, seen->contact};
        }
        // An `ok` before any report is an older command's.
        if (std::holds_alternative<grbl::Ok>(*message) && report) {
            Place place = controller_.place();
            if (place.state == "Idle" && now() - begun < kParsing + options_.delay && (place.position - way.start).norm() <= tolerance()) {
                // Before it begins to move, the machine is idle, too.
                controller_.pass_until(begun + kParsing + options_.delay);
                place = controller_.place();
                if (place.state == "Idle") report = controller_.last_probe();
            }
            if (place.state == "Idle") return ProbeEnd{*report, place};
            report.reset();  // an older command's: this one is still under way
            continue;
        }
        const auto* status = std::get_if<grbl::Status>(&*message);
        const auto place = status != nullptr ? controller_.note(*status) : std::nullopt;
        if (!place) continue;
        if (place->state == "Alarm" || place->state == "Critical" || place->state == "Check") fail_state(place->state);
        if (place->state == "Hold" || place->state == "Door") until = now() + longest;  // the operator's doing; it may go on
        if (place->state != "Idle") {
            stands_since.reset();
            if (is_off(way, *place)) stop_off_way(way);
        } else if (!stands_since) {
            stands_since = now();
        } else if (now() - *stands_since > kAnswerTime + options_.delay) {
            return std::nullopt;
        }
    }
}

// Whether it is the touch that holds the probe closed, and no spark. A tool that was fast needed longer than a spark to stop.
bool GrblDevice::holds(const ProbeEnd& end, const Point& start, double feed_mm_per_s) {
    if (!end.place.probe_closed) return false;
    const MotionModel& k = options_.motion;
    const double way = (end.report.position - start).norm();
    const double speed = std::min(feed_mm_per_s, std::sqrt(2 * k.acceleration_mm_per_s2 * way));
    const auto stopping = std::chrono::duration_cast<std::chrono::nanoseconds>(k.latency + Seconds(speed / k.acceleration_mm_per_s2));
    if (stopping >= kSpark) return true;
    controller_.pass_until(controller_.link().now() + kSpark - stopping);
    return controller_.place().probe_closed;
}

bool GrblDevice::is_off(const Way& way, const Place& place) const { return way.distance_to(place.position) > kOffWay + tolerance(); }

void GrblDevice::stop_off_way(const Way& way) {
    // What came may be a damaged report.
    const Place place = controller_.place();
    if (!is_off(way, place)) return;
    controller_.stop();
    position_ = controller_.place().position;
    controller_.give_up();
    throw BadAnswer(
        fmt::format("the machine on {} left its way from {} to {} (machine coordinates) and was stopped at {}: were bytes of the command "
                    "lost on the line? Check the cable, then resume{}{}",
                    controller_.link().name(), point_text(way.start), point_text(way.target), point_text(position_), kMayBePressed,
                    controller_.link().history()));
}

void GrblDevice::fail_state(const std::string& state) {
    controller_.give_up();
    const std::string name = controller_.link().name();
    const std::string history = controller_.link().history();
    if (state == "Check") {
        throw BadAnswer(
            fmt::format("the machine on {} is in check mode, in which nothing moves and nothing is touched: leave it with $C, then "
                        "resume{}",
                        name, history));
    }
    throw DeviceAlarm(
        0, fmt::format("the machine on {} is in alarm, and what it said of it was lost on the line; then resume{}", name, history));
}

std::optional<GrblDevice::ProbeEnd> GrblDevice::find_out(const Point& start, const ProbeReport& before) {
    const ProbeReport report = controller_.last_probe();
    const Place place = controller_.place();
    const bool is_new = report.position != before.position || report.contact != before.contact;
    // What is latched at the same place as before is no different. Whatever this is, it is checked as any answer.
    const bool has_moved = (place.position - start).norm() > tolerance();
    if (is_new || has_moved) return ProbeEnd{report, place, true};
    return std::nullopt;
}

// A minus that got lost on the line leaves another number. Where that is as credible, or the tool far from what it says that it touched,
// the machine has to say it twice.
void GrblDevice::check_again(const ProbeEnd& end, double feed_mm_per_s) {
    const ProbeReport& report = end.report;
    const double between = longest_overrun(feed_mm_per_s);
    const auto is_doubtful = [between](double c) { return c > 0 && 2 * c <= between; };
    const bool is_far = (end.place.position - report.position).norm() > between;
    if (!is_far && !std::ranges::any_of(report.position, is_doubtful)) return;
    const ProbeReport again = controller_.last_probe();
    if (again.position == report.position && again.contact == report.contact) return;
    controller_.give_up();
    throw BadAnswer(fmt::format(
        "the machine on {} reports a contact at {}, then at {} (machine coordinates): bytes are lost on the line; check the cable, then "
        "resume{}{}",
        controller_.link().name(), point_text(report.position), point_text(again.position), kMayBePressed, controller_.link().history()));
}

std::string GrblDevice::problem_of(const ProbeEnd& end, const Way& way) const {
    const Point& reported = end.report.position;
    if (end.report.contact) return palpate::problem_of({reported, end.place.position}, way, tolerance());
    if ((reported - way.target).norm() > tolerance()) {
        return fmt::format("reports no contact and an end at {}, which is not the target", point_text(reported));
    }
    return palpate::problem_of({{}, end.place.position}, way, tolerance());
}

void GrblDevice::check_answer(ProbeEnd& end, const Way& way, double feed_mm_per_s) {
    std::string what = problem_of(end, way);
    const bool is_far = end.report.contact && (end.place.position - end.report.position).norm() > longest_overrun(feed_mm_per_s);
    if (!what.empty() || is_far) {
        // A byte of the report may have got lost.
        end.place = controller_.place();
        what = problem_of(end, way);
    }
    if (what.empty()) return;
    if (end.place.state != "Idle") controller_.stop();
    controller_.give_up();
    throw BadAnswer(fmt::format(
        "the machine on {} {} (move from {} to {}, machine coordinates): was it moved by something else, did it lose steps? Home it, then "
        "resume{}{}",
        controller_.link().name(), what, point_text(way.start), point_text(way.target), kMayBePressed, controller_.link().history()));
}

void GrblDevice::check_on(const Segment& way, const Point& reported) {
    if (distance_to(way, reported) <= tolerance()) return;
    controller_.give_up();
    throw BadAnswer(
        fmt::format("the machine on {} reports that it rests at {}, which is not on its way between {} and {} (machine coordinates): was "
                    "it moved by something else, did it lose steps? Home it, then resume{}{}",
                    controller_.link().name(), point_text(reported), point_text(way.source), point_text(way.target), kMayBePressed,
                    controller_.link().history()));
}

double GrblDevice::longest_overrun(double feed_mm_per_s) const {
    return palpate::longest_overrun(options_.motion, feed_mm_per_s, tolerance());
}

void GrblDevice::check_overrun(double overrun, double feed_mm_per_s) {
    if (overrun <= longest_overrun(feed_mm_per_s)) return;
    controller_.give_up();
    throw BadAnswer(
        fmt::format("the machine on {} came to rest {} mm past where it reports that its probe changed: was it moved by something else, "
                    "did it lose steps? Home it, then resume{}",
                    controller_.link().name(), number_text(overrun), controller_.link().history()));
}

// --- going back ------------------------------------------------------------------------------------------------------

void GrblDevice::stop_on(const Way& way) {
    controller_.stop();
    last_.reset();  // by the reset in it
    position_ = controller_.resting_place().position;
    check_on({way.start, way.target}, position_);
}

void GrblDevice::stop_and_throw(const Way& way, OnStop on_stop) {
    stop_on(way);
    if (on_stop != OnStop::go_back) throw Stopped(fmt::format("stopped by the operator; the tool rests at {}", point_text(position())));
    back_off(way.start, way.start, OnStop::finish);
    throw Stopped(fmt::format("stopped by the operator; the tool went back to {} and rests there", point_text(position())));
}

void GrblDevice::retract(const Point& contact, const Point& start, double feed_mm_per_s) {
    const double overrun = (position_ - contact).norm();
    back_off(retracted(options_.motion, contact, start), start, OnStop::finish);
    check_overrun(overrun, feed_mm_per_s);
    if (overrun > options_.motion.overtravel_mm) {
        controller_.give_up();
        throw DeviceError(
            fmt::format("the machine on {} ran on {:g} mm past a touch, more than the probe's overtravel of {:g} mm: lower machine.feeds, "
                        "or correct machine.acceleration and machine.latency",
                        controller_.link().name(), overrun, options_.motion.overtravel_mm));
    }
}

void GrblDevice::back_off(Point target, const Point& start, OnStop on_stop) {
    const double feed = options_.motion.feeds.probe_mm_per_s;
    const Segment way{position_, start};
    Place place = controller_.place();
    bool seeks_opening = false;
    for (int bounces = 0;; ++bounces) {
        // A byte of the report may have got lost.
        if (distance_to(way, place.position) > tolerance()) place = controller_.place();
        check_on(way, place.position);
        position_ = place.position;
        if (is_at(target)) {
            if (!place.probe_closed || opens_soon()) return;
            if (is_at(start)) break;
            target = start;
            seeks_opening = true;
        }
        if (bounces == kMaxBounces) break;
        const bool releases = place.probe_closed;
        try {
            const ProbeEnd end = run_probe(releases ? "G38.5" : "G38.3", target, feed, on_stop);
            place = end.place;
            if (end.report.contact) check_overrun((place.position - end.report.position).norm(), feed);
            if (seeks_opening && releases && end.report.contact) {
                target = retracted(options_.motion, end.report.position, start);
                seeks_opening = false;
            }
        } catch (const ProbeClosed&) {
            // It bounced between the question and the move, which did not begin; ALARM:4 keeps the position.
            controller_.unlock();
            last_.reset();
            place = controller_.place();
        }
    }
    controller_.give_up();
    throw ProbeClosed(
        fmt::format("the probe on {} stays closed although the tool went back to {}: the tool is pressed against something, or the probe "
                    "is stuck, bent, or its lead shorted. Free it, then resume{}",
                    controller_.link().name(), point_text(position()), controller_.link().history()));
}

bool GrblDevice::opens_soon() {
    const auto until = controller_.link().now() + kSettling;
    while (controller_.link().now() < until) {
        controller_.pass_until(controller_.link().now() + kSettling / 10);
        if (!controller_.place().probe_closed) return true;
    }
    return false;
}

void GrblDevice::retreat(const Point& target) {
    if (!is_quiet_) require_quiet();
    refuse_disturbed();
    const Point goal = rounded(options_.motion, target + options_.origin);
    position_ = controller_.resting_place().position;
    back_off(goal, goal, OnStop::stay);
}

}  // namespace palpate
