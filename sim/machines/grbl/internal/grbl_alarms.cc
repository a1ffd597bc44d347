// How a virtual GRBL controller stops: resets, alarms, and the faults that it is told to suffer.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <utility>

#include "sim/machines/grbl/internal/grbl_machine.h"

namespace palpate {
namespace {

constexpr Seconds kAlarmTime{0.5};   // the firmware waits so long after every ALARM line
constexpr Seconds kResetTime{0.01};  // from a reset to the banner
constexpr Seconds kBootTime{1.0};    // from the reset button to the banner, a boot loader between

}  // namespace

void GrblMachine::reset() {
    const bool line = (blocked_ && blocked_->line) || critical_line_;
    blocked_.reset();
    if (!tool_.is_moving() && state_ != State::home) {
        finish_reset(line);
        return;
    }
    constexpr int kAbortedCycle = 3;
    constexpr int kAbortedHoming = 6;
    const int code = state_ == State::home ? kAbortedHoming : kAbortedCycle;
    alarm(code, line, [this, line] { finish_reset(line); });
}

void GrblMachine::finish_reset(bool line) {
    // The line that the reset ended says so only now: a stale answer before the banner.
    if (line) say("ok");
    planner_.clear();
    ++counts_.resets;
    wait(kResetTime, Hearing::none, [this] { boot(); });
    blocked_->line = false;
}

void GrblMachine::press_reset() {
    tool_.abort();
    planner_.clear();
    tool_.count_from(Point::Zero());
    homed_ = false;
    silent_ = false;
    output_.drop();
    state_ = settings_.homing() ? State::alarm : State::idle;
    ++counts_.resets;
    wait(kBootTime, Hearing::none, [this] { boot(); });
    blocked_->line = false;
}

void GrblMachine::alarm(int code, bool line, std::function<void()> then) {
    if (tool_.is_moving()) {
        tool_.abort();
        homed_ = false;
    }
    planner_.clear();
    spurious_at_.reset();
    state_ = State::alarm;
    say(fmt::format("ALARM:{}", code));
    wait(kAlarmTime, Hearing::later, std::move(then));
    blocked_->line = line;
}

void GrblMachine::raise_alarm(int code, bool line) {
    constexpr int kHardLimit = 1;
    constexpr int kSoftLimit = 2;
    constexpr int kProbeMissed = 5;
    constexpr int kFirstThatResets = 6;  // homing
    constexpr int kLastThatResets = 9;
    if (code == kHardLimit || code == kSoftLimit) {
        if (code == kHardLimit) homed_ = false;
        alarm(code, line, [this, line] {
            say("[MSG:Reset to continue]");
            critical_ = true;
            critical_line_ = line;
            if (options_.dialect == GrblDialect::grbl) blocked_ = Blocked{Blocked::On::reset, now_, Hearing::all, line, false, {}};
        });
        blocked_->critical = true;
    } else if (code == 3 || (code >= kFirstThatResets && code <= kLastThatResets)) {
        homed_ = false;
        alarm(code, line, [this, line] { finish_reset(line); });
    } else {
        alarm(code, line, [this, code, line] {
            if (code == kProbeMissed) say(probe_report(probe_, settings_.inches()));
            if (line) say("ok");
        });
    }
}

void GrblMachine::handle_due_faults() {
    if (spurious_at_ && now_ + kSameTime >= *spurious_at_) {
        spurious_at_.reset();
        ++counts_.spurious;
        tool_.trigger_spuriously();
    }
    const bool line = blocked_ && blocked_->line;
    if (const auto code = suffer(VirtualFault::When::time, (now_ + kSameTime).count())) raise_alarm(*code, line);
}

// Number of an alarm if that is among what happens now.
std::optional<int> GrblMachine::suffer(VirtualFault::When when, double at) {
    std::optional<int> code;
    for (const VirtualFault& fault : faults_.take(when, at)) {
        if (fault.kind == VirtualFault::Kind::alarm) {
            code = static_cast<int>(fault.argument);
        } else {
            apply(fault);
        }
    }
    if (silent_) return std::nullopt;  // a dead controller raises none
    return code;
}

void GrblMachine::apply(const VirtualFault& fault) {
    using Kind = VirtualFault::Kind;
    switch (fault.kind) {
        case Kind::stale_line:
            say(fault.text);
            break;
        case Kind::lose_output:
            output_.lose(static_cast<std::size_t>(fault.argument));
            break;
        case Kind::late_answer:
            output_.hold_back(now_ + Seconds(fault.argument));
            break;
        case Kind::hang_up:
            link_ = VirtualGrbl::Link::hung_up;
            break;
        case Kind::io_error:
            link_ = VirtualGrbl::Link::io_error;
            break;
        case Kind::press_reset:
            press_reset();
            break;
        case Kind::bounce:
            tool_.bounce(static_cast<int>(fault.argument));
            break;
        case Kind::missed_trigger:
            tool_.miss_next_trigger();
            break;
        case Kind::alarm:
            break;  // suffer() returns it
        case Kind::spurious_trigger:
            if (fault.when == VirtualFault::When::probe) {
                spurious_share_ = fault.argument;
            } else {
                ++counts_.spurious;
                tool_.trigger_spuriously();
            }
            break;
        case Kind::cut_probe:
        case Kind::dead_probe:
        case Kind::mend_probe:
            probe_cut_ = fault.kind == Kind::cut_probe;
            tool_.set_unplugged(fault.kind != Kind::mend_probe);
            break;
        case Kind::pendant_key:
            handle_realtime(static_cast<char>(static_cast<int>(fault.argument)));
            break;
        case Kind::spindle:
            modal_.spindle = static_cast<int>(fault.argument);
            status_.overrides_changed();
            break;
        case Kind::position_zero:
        case Kind::position_frozen:
        case Kind::position_ahead:
        case Kind::position_beside:
        case Kind::position_swapped:
            position_fault_ = fault;
            frozen_position_ = tool_.position();
            position_shift_ = fault.argument * (fault.kind == Kind::position_ahead ? probe_direction_ : probe_direction_.unitOrthogonal());
            break;
        case Kind::latch_late:
            latch_delay_ = Seconds(fault.argument);
            break;
        case Kind::silence:
            tool_.abort();
            planner_.clear();
            blocked_.reset();
            silent_ = true;
            break;
    }
    if (link_ != VirtualGrbl::Link::up) output_.drop();
}

}  // namespace palpate
