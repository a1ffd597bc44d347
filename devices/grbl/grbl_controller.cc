#include "devices/grbl/grbl_controller.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <sstream>

#include "devices/errors.h"
#include "planner/number_text.h"

namespace palpate::grbl {
namespace {

using namespace std::chrono_literals;

constexpr auto kPollInterval = 200ms;
// Grbl answers within milliseconds; a line is on the wire for a few.
constexpr auto kAnswerTime = 2s;
// After a reset some bytes of the old conversation may still come.
constexpr auto kQuiet = 60ms;
// The longest homing cycle of a large, slow machine.
constexpr auto kHomingTime = 300s;
// The longest single probing move: a metre at 1 mm/s.
constexpr auto kLongestMove = 1000s;
// Grbl tells the work offset in one report of thirty at least, the overrides of a machine at rest in one of ten, and grblHAL no less often.
constexpr int kReportsWithOffset = 40;
constexpr int kReportsWithOverrides = 25;
// Of a machine at rest, until two agree.
constexpr int kReadings = 5;
constexpr double kMillimetresPerInch = 25.4;
// Of coordinates that are reported.
constexpr std::size_t kDecimalsOfMillimetres = 3;
constexpr std::size_t kDecimalsOfInches = 4;

template <typename T>
bool is(const Message& message) {
    return std::holds_alternative<T>(message);
}

bool is_feedback(const Message& message, std::string_view kind) {
    const auto* feedback = std::get_if<Feedback>(&message);
    return feedback != nullptr && feedback->kind == kind;
}

// Of "G0 G54 … M5 M9 T0 F0 S0", in the letters that reports have for them. Nothing unless it tells of spindle and coolant.
std::optional<std::string> accessories_of(const std::string& modes) {
    bool has_spindle = false;
    bool has_coolant = false;
    std::string running;
    std::istringstream words(modes);
    for (std::string word; words >> word;) {
        has_spindle |= word == "M3" || word == "M4" || word == "M5";
        has_coolant |= word == "M7" || word == "M8" || word == "M9";
        if (word == "M3") running += 'S';
        if (word == "M4") running += 'C';
        if (word == "M7") running += 'M';
        if (word == "M8") running += 'F';
    }
    return has_spindle && has_coolant ? std::optional(running) : std::nullopt;
}

bool is_moving(const Place& place) {
    // Door:2 is slowing down, Door:3 going on.
    return place.state == "Run" || place.state == "Jog" || place.state == "Home" || (place.state == "Hold" && place.substate != 0) ||
           (place.state == "Door" && place.substate.value_or(0) >= 2);
}

}  // namespace

const char* to_string(State state) {
    switch (state) {
        case State::connecting:
            return "connecting";
        case State::locked:
            return "locked";
        case State::idle:
            return "idle";
        case State::probing:
            return "probing";
        case State::hold:
            return "hold";
        case State::alarm:
            return "alarm";
        case State::lost:
            return "lost";
    }
    return "";
}

std::optional<double> Identity::number(int setting) const {
    const auto found = settings.find(setting);
    if (found == settings.end()) return std::nullopt;
    double value = 0;
    const std::string& text = found->second;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

double Controller::unit_mm() const { return identity_.number(setting::kReportInches).value_or(0) == 1 ? kMillimetresPerInch : 1.0; }

// --- messages --------------------------------------------------------------------------------------------------------

std::optional<Message> Controller::next(std::chrono::nanoseconds until) {
    std::optional<Message> message = link_.receive(until);
    if (!message) return message;
    if (const auto* alarm = std::get_if<Alarm>(&*message)) on_alarm(*alarm);
    if (const auto* status = std::get_if<Status>(&*message)) note_conditions(*status);
    if (is<Banner>(*message) && state_ != State::connecting) {
        state_ = State::lost;
        throw PositionLost(
            fmt::format("the controller on {} has started anew by itself: its reset button, or its supply. Where the tool is, nobody knows "
                        "now: home the machine, then resume{}",
                        link_.name(), link_.history()));
    }
    return message;
}

void Controller::note_conditions(const Status& status) {
    if (!status.running.empty()) conditions_.running = status.running;
    if (status.feed_override) conditions_.feed_override = status.feed_override;
}

std::optional<int> Controller::feed_override() {
    conditions_.feed_override.reset();
    for (int k = 0; k < kReportsWithOverrides && !conditions_.feed_override; ++k) (void)place();
    return conditions_.feed_override;
}

std::string Controller::active_accessories() {
    const auto is_whole = [](const Message& m) { return is_feedback(m, "GC") && accessories_of(std::get<Feedback>(m).text); };
    std::string active;
    for (const Message& message : ask("$G", is_whole)) {
        if (is_whole(message)) active = *accessories_of(std::get<Feedback>(message).text);
    }
    return active;
}

// A byte that got lost may leave another number: an offset counts once it was told twice.
void Controller::note_offset(const Point& offset) {
    const bool is_second = work_offset_ == offset || doubtful_offset_ == offset;
    is_offset_sure_ = is_second;
    doubtful_offset_.reset();
    if (is_second || !work_offset_) {
        work_offset_ = offset;
    } else {
        doubtful_offset_ = offset;
    }
}

void Controller::forget_offset() {
    is_offset_sure_ = false;
    work_offset_.reset();
    doubtful_offset_.reset();
}

const Point& Controller::work_offset() {
    for (int k = 0; k < 2 * kReportsWithOffset && !is_offset_sure_; ++k) (void)place();
    if (!is_offset_sure_ && has_reported_) {
        throw DeviceRefused(0, fmt::format("the machine on {} reports its status, but never the work offset (WCO): its firmware was built "
                                           "without (REPORT_FIELD_WORK_COORD_OFFSET), and is not supported{}",
                                           link_.name(), link_.history()));
    }
    if (!is_offset_sure_) fail_silent("a status report with the work offset (WCO)");
    return *work_offset_;
}

std::optional<Place> Controller::note(const Status& status) {
    has_reported_ = true;
    const double unit = unit_mm();
    if (status.offset) note_offset(unit * *status.offset);
    if (status.homed) homed_ = status.homed;
    Place place{status.state, status.substate, Point::Zero(), status.probe_closed, status.probe_unplugged, homed_};
    if (status.machine) {
        place.position = unit * *status.machine;
    } else if (work_offset_) {
        place.position = unit * *status.work + *work_offset_;
    } else {
        return std::nullopt;
    }
    return place;
}

void Controller::require_reports() const {
    if (identity_.firmware != Firmware::grblhal) return;
    const auto mask = identity_.number(setting::kReportMask);
    if (!mask) return;
    struct Part {
        unsigned bit;
        const char* what;
    };
    static constexpr std::array<Part, 3> kNeeded = {
        {{16, "the probe's state (pin state)"}, {32, "the work offset"}, {128, "where a probe touched (probe coordinates)"}}};
    const auto bits = static_cast<unsigned>(*mask);
    unsigned wanted = bits;
    std::vector<std::string> missing;
    for (const Part& part : kNeeded) {
        wanted |= part.bit;
        if ((bits & part.bit) == 0U) missing.push_back(fmt::format("{}, bit {}", part.what, std::countr_zero(part.bit)));
    }
    if (missing.empty()) return;
    throw DeviceRefused(0, fmt::format("the reports of the machine on {} leave out {}: nothing has moved; say $10={} to it, then go on",
                                       link_.name(), fmt::join(missing, "; "), wanted));
}

void Controller::fail_unknown() {
    constexpr const char* kSupported = "Grbl 1.1, grblHAL and FluidNC are supported";
    const std::string& version = identity_.version;
    if (version.starts_with("Grbl 0.") || unknown_.starts_with("<Idle,") || unknown_.starts_with("<Alarm,")) {
        throw DeviceTimeout(fmt::format("what answers on {} is {}, which is older than Grbl 1.1: update the board's firmware; {}{}",
                                        link_.name(), version.empty() ? "a Grbl" : version, kSupported, link_.history()));
    }
    if (!unknown_.empty()) {
        throw DeviceTimeout(
            fmt::format("something answers on {}, but not as GRBL does: it says \"{}\"; is it another firmware, another "
                        "port (palpate ports), is machine.grbl.baud right? {}{}",
                        link_.name(), unknown_, kSupported, link_.history()));
    }
    throw DeviceTimeout(fmt::format(
        "nothing answers on {} within {} s: is it the right port (palpate ports), is machine.grbl.baud right, is the machine on? "
        "A board that needs longer to start has machine.grbl.boot_time{}",
        link_.name(), number_text(std::chrono::duration<double>(boot_time_).count()), link_.history()));
}

std::vector<Message> Controller::ask(const std::string& line, const std::function<bool(const Message&)>& is_answer) {
    link_.send(line);
    const auto until = link_.now() + kAnswerTime + delay_;
    std::vector<Message> messages;
    bool answered = false;
    while (const auto message = next(until)) {
        if (const auto* error = std::get_if<Error>(&*message)) fail(*error);
        if (is<Ok>(*message) && answered) return messages;
        answered |= is_answer(*message);
        messages.push_back(*message);
    }
    fail_silent(fmt::format("the answer to {}", line));
}

void Controller::fail(const Error& error) {
    if (state_ == State::probing) {
        // It may be an older command's, and the tool move or begin to: nobody will watch it any more. Where it is, nobody asks again.
        stop();
        state_ = State::lost;
    }
    link_.send("");
    link_.drain(kQuiet + delay_);
    if (error.code == 9) {
        state_ = State::locked;
        throw DeviceAlarm(0, fmt::format("the machine on {} is locked: home it, then resume{}", link_.name(), link_.history()));
    }
    throw DeviceRefused(error.code, fmt::format("the machine on {} refused a command, error:{}, {}{}", link_.name(), error.code,
                                                explain_error(error.code), link_.history()));
}

void Controller::fail_silent(const std::string& awaited) {
    // It may still hear what it does not answer.
    if (state_ == State::probing) link_.send_realtime(kFeedHold);
    state_ = State::lost;
    throw DeviceTimeout(
        fmt::format("no answer on {} while waiting for {}: check cable and supply, and that no other program has the port; then resume{}",
                    link_.name(), awaited, link_.history()));
}

void Controller::on_alarm(const Alarm& alarm) {
    state_ = State::alarm;
    // The firmware says more: an `ok` for the probing move, a message, a banner.
    const std::string history = link_.history();
    link_.drain(kQuiet + delay_);
    if (needs_reset(alarm.code)) reset();
    state_ = State::locked;
    const std::string text = fmt::format("ALARM:{} on {}, {}; then resume{}", alarm.code, link_.name(), explain_alarm(alarm.code), history);
    if (alarm.code == 4) throw ProbeClosed(text);
    if (loses_position(alarm.code)) throw PositionLost(text);
    throw DeviceAlarm(alarm.code, text);
}

// --- connecting ------------------------------------------------------------------------------------------------------

bool Controller::wait_for_first_status(const StopToken& stop) {
    const auto until = link_.now() + boot_time_;
    while (link_.now() < until) {
        if (stop.stop_requested()) stop_unheard();
        link_.send_realtime(kAskStatus);
        const auto next_poll = link_.now() + 2 * kPollInterval + delay_;
        while (const auto message = link_.receive(next_poll)) {
            if (const auto* banner = std::get_if<Banner>(&*message)) identity_.version = banner->version;
            if (const auto* unknown = std::get_if<Unknown>(&*message)) unknown_ = unknown->text;
            if (is<Status>(*message)) return true;
        }
        // In the trap of its soft limit the controller hears nothing but a reset, and nothing moves there. One is swallowed that comes too
        // early (devices/FACTS.md, "GRBL"): it is sent again, which there is time for once.
        if (link_.now() > until - boot_time_ / 2 && !reset_until_banner(until, stop)) return false;
    }
    return false;
}

void Controller::stop_unheard() {
    link_.send_realtime(kFeedHold);  // an earlier host's motion, for all that is known
    state_ = State::lost;
    throw Stopped(fmt::format("stopped before the machine on {} had answered; it was told to hold", link_.name()));
}

void Controller::connect(const StopToken& stop) {
    state_ = State::connecting;
    if (!wait_for_first_status(stop)) {
        state_ = State::lost;
        fail_unknown();
    }
    // Lines are heard at a standstill only.
    const std::string state = wait_for_standstill(kLongestMove, stop).state;
    if (state == "Check") {
        throw DeviceRefused(0, fmt::format("the machine on {} is in check mode, in which nothing moves: leave it with $C", link_.name()));
    }
    if (state == "Critical") {
        throw DeviceAlarm(0,
                          fmt::format("the machine on {} says Critical: it stopped for good, by a limit or an error in its configuration; "
                                      "see what it says when it starts ($SS), reset it, then go on",
                                      link_.name()));
    }
    if (state == "Door" || state == "Sleep") {
        throw DeviceAlarm(0, fmt::format("the machine on {} says {}: close the door or wake it, then go on", link_.name(), state));
    }
    // A hold that an earlier host left, or an alarm out of which may lead nothing else; a reset at a standstill keeps the position.
    if (state == "Hold" || state == "Alarm") reset();
    // An error that was never acknowledged would answer everything that follows on grblHAL.
    link_.send("");
    link_.drain(kQuiet + delay_);
    read_identity();
    require_reports();
    forget_offset();  // what came until now was in units not known then
    (void)work_offset();
    state_ = place().state == "Alarm" ? State::locked : State::idle;
}

void Controller::read_identity() {
    const auto has_settings = [](const Message& m) { return is<Setting>(m); };
    for (const Message& message : ask("$$", has_settings)) {
        if (const auto* setting = std::get_if<Setting>(&message)) identity_.settings[setting->number] = setting->value;
    }
    link_.expect_decimals(unit_mm() == 1.0 ? kDecimalsOfMillimetres : kDecimalsOfInches);
    for (const Message& message : ask("$I", [](const Message& m) { return is_feedback(m, "VER"); })) {
        if (is_feedback(message, "FIRMWARE") && std::get<Feedback>(message).text == "grblHAL") identity_.firmware = Firmware::grblhal;
        if (!is_feedback(message, "VER")) continue;
        const std::string& version = std::get<Feedback>(message).text;
        if (version.find("FluidNC") != std::string::npos) identity_.firmware = Firmware::fluidnc;
        identity_.version =
            identity_.version.empty() ? fmt::format("Grbl {}", version) : fmt::format("{} ({})", identity_.version, version);
    }
}

void Controller::pass_until(std::chrono::nanoseconds until) {
    while (next(until)) {
    }
}

Place Controller::place() {
    pass_until(link_.now());  // a report that was asked for earlier says where the tool was then
    // On a network such a report may be under way yet.
    for (const auto late = link_.now() + delay_; delay_.count() > 0 && link_.unanswered() > 0 && link_.now() < late;) (void)next(late);
    link_.forget_unanswered();  // what has not come by then is lost
    const auto until = link_.now() + kAnswerTime + delay_;
    while (link_.now() < until) {
        link_.send_realtime(kAskStatus);
        // A report may get lost; an old one that still comes is as good a place to wait for the next.
        const auto next_poll = link_.now() + kPollInterval + delay_;
        while (const auto message = next(next_poll)) {
            const auto* status = std::get_if<Status>(&*message);
            if (status == nullptr) continue;
            if (const auto place = note(*status)) return *place;
            break;  // WPos without an offset yet: the next report has it
        }
    }
    fail_silent("a status report");
}

Place Controller::resting_place() {
    (void)work_offset();
    Place last = place();
    for (int k = 0; k < kReadings; ++k) {
        Place again = place();
        if (again.position == last.position) return again;
        last = again;
    }
    fail_silent("two reports of status that agree");
}

Place Controller::wait_for_standstill(std::chrono::nanoseconds longest, const StopToken& stop) {
    const auto until = link_.now() + longest;
    while (true) {
        Place place = this->place();
        if (!is_moving(place)) return place;
        if (stop.stop_requested()) {
            if (place.state == "Home") {
                reset();  // homing cannot be held
            } else {
                state_ = State::probing;
                this->stop();
            }
            state_ = State::lost;
            throw Stopped(fmt::format("the machine on {} was carrying out an earlier command, and was stopped", link_.name()));
        }
        if (link_.now() > until) fail_silent("the end of a motion");
        (void)next(link_.now() + kPollInterval);
    }
}

// --- ways out --------------------------------------------------------------------------------------------------------

bool Controller::reset_until_banner(std::chrono::nanoseconds until, const StopToken& stop) {
    // Nothing may be sent before the banner; a reset can be swallowed, and is sent again.
    while (link_.now() < until) {
        link_.send_realtime(kReset);
        const auto again = link_.now() + kAnswerTime + delay_;
        while (link_.now() < again) {
            if (stop.stop_requested()) stop_unheard();
            const auto message = link_.receive(std::min(again, link_.now() + kPollInterval));
            if (message && is<Banner>(*message)) return true;
        }
    }
    return false;
}

void Controller::reset() {
    state_ = State::connecting;
    has_motion_mode_ = true;
    forget_conditions();
    forget_offset();  // a reset ends a shift of it (G92), and goes back to G54
    if (!reset_until_banner(link_.now() + boot_time_)) fail_silent("the banner after a reset");
    link_.drain(kQuiet + delay_);
}

void Controller::stop() {
    if (state_ != State::probing && state_ != State::hold) return;
    const auto until = link_.now() + kLongestMove;
    Place place;
    do {
        if (link_.now() > until) fail_silent("the end of a motion");
        link_.send_realtime(kFeedHold);
        place = this->place();
        // A hold that got lost on the wire is sent again until the tool slows down.
        while (is_moving(place) && place.state != "Run" && link_.now() < until) {
            (void)next(link_.now() + kPollInterval);
            place = this->place();
        }
    } while (is_moving(place));
    state_ = State::hold;
    // Also a probing move that ended by itself may leave its `ok` behind: only a reset tells old answers from new ones.
    reset();
    state_ = this->place().state == "Alarm" ? State::locked : State::idle;
    if (state_ == State::locked && place.state != "Alarm") {
        throw PositionLost(
            fmt::format("the machine on {} locked itself when it was stopped: home it, then resume{}", link_.name(), link_.history()));
    }
}

void Controller::home(const StopToken& stop) {
    if (stop.stop_requested()) throw Stopped("stopped before homing; nothing has moved");
    link_.send("$H");
    const auto until = link_.now() + kHomingTime;
    while (link_.now() < until) {
        if (stop.stop_requested()) {
            // Homing cannot be held, only ended; where the tool is, nobody knows then.
            reset();
            state_ = State::lost;
            throw PositionLost(fmt::format("homing on {} was stopped by the operator: home again, then resume", link_.name()));
        }
        const auto message = next(link_.now() + kPollInterval);
        if (!message) continue;
        if (const auto* error = std::get_if<Error>(&*message)) fail(*error);
        if (!is<Ok>(*message)) continue;
        // An older command's `ok` may come first: the machine itself says whether it has homed.
        const Place place = wait_for_standstill(kHomingTime);
        if (place.state != "Idle") continue;
        homed_ = true;
        state_ = State::idle;
        return;
    }
    fail_silent("the end of homing");
}

void Controller::unlock() {
    (void)ask("$X", [](const Message& m) { return is_feedback(m, "MSG"); });
    const Place place = this->place();
    if (place.state == "Alarm") {
        throw DeviceAlarm(0, fmt::format("the machine on {} stays locked after $X{}", link_.name(), link_.history()));
    }
    state_ = State::idle;
}

ProbeReport Controller::last_probe() {
    // FluidNC says nothing of it before the first; a damaged line is no reason to think so.
    const bool may_have_none = identity_.firmware == Firmware::fluidnc;
    const auto is_last = [&](const Message& m) { return is<ProbeReport>(m) || (may_have_none && is_feedback(m, "TLO")); };
    bool is_whole = true;
    for (const Message& message : ask("$#", is_last)) {
        if (const auto* report = std::get_if<ProbeReport>(&message)) return {unit_mm() * report->position, report->contact};
        is_whole = is_whole && !is<Unknown>(message);
    }
    if (may_have_none && is_whole) return {};
    fail_silent("the answer to $#");
}

void Controller::clear_motion_mode() {
    link_.send("G80");
    const auto is_cleared = [](const Message& m) { return is_feedback(m, "GC") && std::get<Feedback>(m).text.starts_with("G80 "); };
    (void)ask("$G", is_cleared);
    has_motion_mode_ = false;
}

void Controller::begin(const std::string& line) {
    pass_until(link_.now());
    // After a reset it is G0: a line whose G38.3 got lost would be an unguarded move. Without any mode such a line is an error.
    if (has_motion_mode_) clear_motion_mode();
    state_ = State::probing;
    link_.send(line);
}

}  // namespace palpate::grbl
