// What the lines do that a virtual GRBL controller receives.
#include <algorithm>
#include <tuple>

#include "devices/motion_model.h"
#include "sim/machines/grbl/internal/grbl_errors.h"
#include "sim/machines/grbl/internal/grbl_machine.h"

namespace palpate {
namespace {

constexpr double kLastSetting = 255;

constexpr int kSoftLimitAlarm = 2;
constexpr int kProbeClosedAlarm = 4;
constexpr int kProbeMissedAlarm = 5;

constexpr double kMinimumFeed = GrblPlanner::kMinimumFeed;
constexpr double kHomingFeed = 25.0;  // mm/s
constexpr Seconds kHomingLatch{1.0};  // back off the switches and touch them again
constexpr int kBounces = 2;           // of a move that bounces by chance

bool goes_away(int motion) { return motion == 384 || motion == 385; }
bool may_fail(int motion) { return motion == 383 || motion == 385; }

double feed_of(const GrblModal& modal, const GrblSettings& settings) {
    return std::max(kMinimumFeed, std::min(modal.feed_mm_per_min / kSecondsPerMinute, settings.max_feed_mm_per_s()));
}

}  // namespace

void GrblMachine::execute(const GrblLine& line) {
    const std::string& text = line.text();
    if (!text.empty() || line.is_too_long()) {
        ++counts_.lines;
        if (const auto code = suffer(VirtualFault::When::line, static_cast<double>(counts_.lines))) {
            raise_alarm(*code, true);
            return;
        }
        if (silent_ || blocked_) return;  // by a fault
    }
    if (text.empty() || text[0] == '$') sticky_error_ = 0;
    if (sticky_error_ != 0) {
        answer(sticky_error_);
    } else if (line.is_too_long()) {
        answer(kLineTooLong);
    } else if (text.empty()) {
        answer(0);
    } else if (text[0] == '$') {
        execute_system(text);
    } else if (state_ == State::alarm || state_ == State::jog) {
        answer(kLocked);
    } else {
        execute_code(text);
    }
}

void GrblMachine::execute_system(std::string_view line) {
    const bool at_rest = state_ == State::idle || state_ == State::alarm;
    if (line == "$X") {
        unlock();
    } else if (line == "$C") {
        toggle_check_mode();
    } else if (line.starts_with("$J=")) {
        jog(line.substr(3));
    } else if (line == "$G") {
        output_.say(modal_report(modal_));
        answer(0);
    } else if (!at_rest) {
        answer(kNotIdle);
    } else if (line == "$H") {
        home();
    } else if (line.find('=') != std::string_view::npos) {
        answer(execute_setting(line));
    } else {
        answer(execute_report(line));
    }
}

int GrblMachine::execute_report(std::string_view line) {
    if (line == "$") {
        say("[HLP:$$ $# $G $I $x=val $J=line $C $X $H ~ ! ? ctrl-x]");
    } else if (line == "$$") {
        output_.say(settings_.dump());
    } else if (line == "$#") {
        const bool has_none = options_.dialect == GrblDialect::fluidnc && !has_probed_;
        output_.say(parameters_report(frame_, has_none ? std::nullopt : std::optional(probe_), settings_.inches()));
    } else if (line == "$I") {
        output_.say(version_report(options_.dialect));
    } else {
        return kUnknownCommand;
    }
    return 0;
}

int GrblMachine::execute_setting(std::string_view line) {
    line.remove_prefix(1);  // $
    const std::optional<double> number = take_number(line);
    if (!number) return kBadNumber;
    if (!line.starts_with('=')) return kUnknownCommand;
    line.remove_prefix(1);
    const std::optional<double> value = take_number(line);
    if (!value) return kBadNumber;
    if (!line.empty() || *number < 0.0 || *number > kLastSetting) return kUnknownCommand;
    return settings_.set(static_cast<int>(*number), *value);
}

void GrblMachine::toggle_check_mode() {
    if (state_ == State::check) {
        say("[MSG:Disabled]");
        answer(0);
        state_ = State::idle;
        finish_reset(false);
    } else if (state_ == State::idle) {
        state_ = State::check;
        say("[MSG:Enabled]");
        answer(0);
    } else {
        answer(kNotIdle);
    }
}

void GrblMachine::unlock() {
    if (critical_) {
        answer(kResetRequired);
        return;
    }
    if (state_ == State::alarm) {
        say("[MSG:Caution: Unlocked]");
        state_ = State::idle;
        frame_.position = tool_.position();
    }
    answer(0);
}

void GrblMachine::home() {
    if (critical_) {
        answer(kResetRequired);
        return;
    }
    if (!settings_.homing()) {
        answer(kHomingDisabled);
        return;
    }
    state_ = State::home;
    const double way = (options_.homed_position - tool_.true_position()).norm();
    wait(Seconds(way / kHomingFeed) + kHomingLatch, Hearing::all, [this] {
        tool_.place(options_.homed_position);
        frame_.position = tool_.position();
        homed_ = true;
        state_ = State::idle;
        answer(0);
    });
}

bool GrblMachine::is_beyond_limits(const Point& target) const {
    return settings_.soft_limits() && !tool_.options().limits.contains(target);
}

void GrblMachine::jog(std::string_view line) {
    if (state_ != State::idle && state_ != State::jog) {
        answer(kNotIdle);
        return;
    }
    const GrblWords words = parse_words(line);
    const GrblBlock block = words.error != 0 ? GrblBlock{.error = words.error} : interpret(words.words, modal_, frame_, GrblLineKind::jog);
    if (block.error != 0 || is_beyond_limits(block.target)) {
        answer(block.error != 0 ? block.error : kJogBeyondLimits);
        return;
    }
    const double feed = feed_of(block.modal, settings_);
    const auto begin = [this, target = block.target, feed] {
        state_ = State::jog;
        frame_.position = target;
        planner_.add({target, feed, VirtualTool::Guard::none});
        answer(0);
    };
    blocked_ = Blocked{Blocked::On::slot, now_, Hearing::all, true, false, begin};
}

void GrblMachine::execute_code(std::string_view line) {
    const GrblWords words = parse_words(line);
    const GrblBlock block = words.error != 0 ? GrblBlock{.error = words.error} : interpret(words.words, modal_, frame_);
    if (block.error != 0) {
        answer(block.error);
        return;
    }
    const bool moved_origin = block.modal.work_system != modal_.work_system;
    const auto runs = [](const GrblModal& modal) { return std::tuple(modal.spindle, modal.mist, modal.flood); };
    if (runs(block.modal) != runs(modal_)) status_.overrides_changed();
    modal_ = block.modal;
    if (moved_origin) status_.offset_changed();
    switch (block.action) {
        case GrblBlock::Action::none:
            answer(0);
            return;
        case GrblBlock::Action::rapid:
        case GrblBlock::Action::line:
            execute_motion(block);
            return;
        case GrblBlock::Action::probe:
            if (state_ == State::check) {
                answer(0);
            } else {
                wait_for_rest([this, block] { begin_probe(block); });
            }
            return;
        case GrblBlock::Action::dwell:
            wait_for_rest(
                [this, block] { wait(state_ == State::check ? Seconds(0.0) : block.dwell, Hearing::all, [this] { answer(0); }); });
            return;
        case GrblBlock::Action::set_work_system:
            frame_.work[block.work_system] = block.target;
            break;
        case GrblBlock::Action::set_shift:
            frame_.shift = block.target;
            break;
    }
    status_.offset_changed();
    answer(0);
}

void GrblMachine::execute_motion(const GrblBlock& block) {
    if (is_beyond_limits(block.target)) {
        // It comes to rest before it complains, so that no step is lost.
        planner_.cancel();
        wait_for_rest([this] { raise_alarm(kSoftLimitAlarm, true); });
        return;
    }
    if (state_ == State::check) {
        frame_.position = block.target;
        answer(0);
        return;
    }
    const bool is_rapid = block.action == GrblBlock::Action::rapid;
    const double feed = is_rapid ? std::max(kMinimumFeed, settings_.max_feed_mm_per_s()) : feed_of(modal_, settings_);
    const GrblMove move{block.target, feed, VirtualTool::Guard::none, is_rapid ? GrblMove::Override::rapid : GrblMove::Override::feed,
                        settings_.max_feed_mm_per_s()};
    const auto begin = [this, move] {
        state_ = State::run;
        frame_.position = move.target;
        planner_.add(move);
        answer(0);
    };
    blocked_ = Blocked{Blocked::On::slot, now_, Hearing::all, true, false, begin};
}

void GrblMachine::begin_probe(const GrblBlock& block) {
    const int motion = block.modal.motion;
    ++counts_.probes;
    tool_.bounce(0);
    spurious_share_ = faults_.draw_spurious();
    if (faults_.draw_bounce()) tool_.bounce(kBounces);
    if (const auto code = suffer(VirtualFault::When::probe, static_cast<double>(counts_.probes))) {
        raise_alarm(*code, true);
        return;
    }
    if (silent_ || blocked_) return;  // by a fault
    probe_.succeeded = false;
    const bool lead_missed = options_.dialect == GrblDialect::grblhal && probe_cut_;
    if (tool_.is_probe_closed() != goes_away(motion) || lead_missed) {
        alarm(kProbeClosedAlarm, true, [this] { answer(0); });
        return;
    }
    if (is_beyond_limits(block.target)) {
        raise_alarm(kSoftLimitAlarm, true);
        return;
    }
    const double feed = feed_of(modal_, settings_);
    const double length = (block.target - tool_.position()).norm();
    probe_feed_mm_per_s_ = feed;
    if (length > 0.0) probe_direction_ = (block.target - tool_.position()) / length;
    if (spurious_share_) spurious_at_ = now_ + *spurious_share_ * move_duration(tool_.options().motion, length, feed);
    const GrblMove move{block.target, feed, goes_away(motion) ? VirtualTool::Guard::until_release : VirtualTool::Guard::until_contact,
                        GrblMove::Override::feed, settings_.max_feed_mm_per_s()};
    const auto begin = [this, motion, move] {
        state_ = State::run;
        planner_.add(move);
        wait_for_rest([this, motion] { finish_probe(motion); });
    };
    if (options_.parse_time.count() > 0) {
        wait(options_.parse_time, Hearing::all, begin);
    } else {
        begin();
    }
}

void GrblMachine::finish_probe(int motion) {
    spurious_at_.reset();
    auto trigger = tool_.trigger();
    const Point end = tool_.position();
    if (trigger && !goes_away(motion)) {
        if (const auto code = suffer(VirtualFault::When::contact, static_cast<double>(++contacts_))) {
            raise_alarm(*code, true);
            return;
        }
        if (silent_ || blocked_) return;  // by a fault
    }
    if (trigger) *trigger += latch_delay_.count() * probe_feed_mm_per_s_ * probe_direction_;
    if (trigger || may_fail(motion)) {
        probe_ = {trigger.value_or(end), trigger.has_value()};
        has_probed_ = true;
        if (settings_.reports().probes) say(probe_report(probe_, settings_.inches()));
        answer(0);
        return;
    }
    alarm(kProbeMissedAlarm, true, [this, end] {
        // Grbl leaves the previous contact in its record.
        if (options_.dialect != GrblDialect::grbl) probe_.position = end;
        say(probe_report(probe_, settings_.inches()));
        answer(0);
    });
}

}  // namespace palpate
