#include "sim/machines/grbl/internal/grbl_machine.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace palpate {
namespace {

constexpr std::size_t kBufferSize = 128;

constexpr char kReset = 0x18;
constexpr char kJogCancel = static_cast<char>(0x85);

bool is_realtime(char c) { return c == '?' || c == '!' || c == '~' || c == kReset || static_cast<unsigned char>(c) >= 0x80; }

}  // namespace

GrblMachine::GrblMachine(VirtualTool& tool, const VirtualGrblOptions& options)
    : tool_(tool), options_(options), settings_(options, tool.options()), status_(options.dialect), faults_(options), planner_(tool) {
    frame_.work[0] = options.work_offset;
    if (options.miss_rate > 0.0) tool_.set_miss_share(options.miss_rate, options.seed);
    homed_ = options.knows_position && !options.locked;
    if (!options.knows_position) tool_.count_from(Point::Zero());
    state_ = options.locked ? State::alarm : State::idle;
    if (options.fresh_eeprom && options.dialect == GrblDialect::grbl) {
        say("error:7");
        output_.say(settings_.dump());
    }
    boot();
    handle_due_faults();
}

// After any reset. The state has been decided.
void GrblMachine::boot() {
    buffer_.clear();
    line_.clear();
    last_byte_ = '\0';
    planner_.clear();
    modal_ = {};
    overrides_ = {};
    planner_.set_overrides(overrides_);
    frame_.position = tool_.position();
    frame_.shift = Point::Zero();
    probe_ = {};
    has_probed_ = false;
    sticky_error_ = 0;
    critical_ = false;
    critical_line_ = false;
    reset_asked_ = false;
    status_asked_ = false;
    spurious_at_.reset();
    status_.restart();
    if (state_ != State::alarm) state_ = State::idle;
    output_.say("\r\n");
    if (options_.dialect == GrblDialect::fluidnc) say("[MSG:INFO: FluidNC v3.9.1]");
    say(palpate::banner(options_.dialect));
    if (state_ == State::alarm) say("[MSG:'$H'|'$X' to unlock]");
}

std::string GrblMachine::banner() const { return palpate::banner(options_.dialect) + "\r\n"; }

void GrblMachine::receive(std::string_view bytes) {
    for (const char c : bytes) {
        if (silent_ || link_ != VirtualGrbl::Link::up) return;
        if (blocked_ && blocked_->hearing == Hearing::none) continue;
        if (buffer_.size() >= kBufferSize) continue;
        if (is_realtime(c)) {
            handle_realtime(c);
        } else {
            buffer_.push_back(c);
        }
        run();
    }
}

void GrblMachine::advance(Seconds time) {
    const Seconds end = now_ + time;
    while (true) {
        const auto next = time_to_event();
        const Seconds left = std::max(Seconds(0.0), end - now_);
        const bool event = next && *next <= left;
        const Seconds step = event ? *next : left;
        tool_.advance(step);
        now_ += step;
        output_.release(now_ + kSameTime);
        handle_due_faults();
        run();
        if (!event) return;
    }
}

std::optional<Seconds> GrblMachine::time_to_event() const {
    std::optional<Seconds> next = tool_.time_to_event();
    const auto consider = [&](const std::optional<Seconds>& time) {
        if (!time) return;
        const Seconds left = std::max(Seconds(0.0), *time - now_);
        next = next ? std::min(*next, left) : left;
    };
    consider(faults_.next_time());
    consider(output_.held_until());
    consider(spurious_at_);
    if (blocked_ && blocked_->on == Blocked::On::time) consider(blocked_->until);
    return next;
}

std::string GrblMachine::take_output() { return link_ == VirtualGrbl::Link::up ? output_.take() : std::string(); }

void GrblMachine::unplug() {
    link_ = VirtualGrbl::Link::hung_up;
    output_.drop();
}

void GrblMachine::plug_in() { link_ = VirtualGrbl::Link::up; }

// The loop: as far as it comes now.
void GrblMachine::run() {
    while (!silent_) {
        planner_.update();
        note_rest();
        if (blocked_) {
            if (!is_over(*blocked_)) return;
            const Blocked over = *std::exchange(blocked_, std::nullopt);
            unblock(over);
            continue;
        }
        if (state_ == State::hold || buffer_.empty()) return;
        const char c = buffer_.front();
        buffer_.pop_front();
        // grblHAL takes CR LF for one end of a line, Grbl for two: it answers the empty line between them.
        const bool second_half = options_.dialect == GrblDialect::grblhal && c == '\n' && last_byte_ == '\r';
        last_byte_ = c;
        if (second_half) continue;
        if (c == '\n' || c == '\r') {
            execute(std::exchange(line_, {}));
        } else {
            line_.add(c);
        }
    }
}

void GrblMachine::note_rest() {
    if (!planner_.is_empty() || (state_ != State::run && state_ != State::jog)) return;
    state_ = State::idle;
    frame_.position = tool_.position();
}

bool GrblMachine::is_over(const Blocked& blocked) const {
    switch (blocked.on) {
        case Blocked::On::time:
            return now_ + kSameTime >= blocked.until;
        case Blocked::On::rest:
            return planner_.is_empty() && state_ != State::hold;
        case Blocked::On::slot:
            return planner_.free_blocks() > 0 && state_ != State::hold;
        case Blocked::On::reset:
            break;
    }
    return false;
}

void GrblMachine::unblock(const Blocked& blocked) {
    const bool reset_asked = std::exchange(reset_asked_, false);
    const bool status_asked = std::exchange(status_asked_, false);
    if (reset_asked && !blocked.critical) {
        finish_reset(blocked.line);
        return;
    }
    // Grbl stays deaf after a critical alarm: the request is lost.
    if (status_asked && !(blocked.critical && options_.dialect == GrblDialect::grbl)) say_status();
    blocked.then();
}

void GrblMachine::wait(Seconds time, Hearing hearing, std::function<void()> then) {
    blocked_ = Blocked{Blocked::On::time, now_ + time, hearing, true, false, std::move(then)};
}

void GrblMachine::wait_for_rest(std::function<void()> then) {
    blocked_ = Blocked{Blocked::On::rest, now_, Hearing::all, true, false, std::move(then)};
}

void GrblMachine::handle_realtime(char c) {
    if (blocked_ && blocked_->hearing == Hearing::later) {
        reset_asked_ = reset_asked_ || c == kReset;
        status_asked_ = status_asked_ || c == '?';
        return;
    }
    if (blocked_ && blocked_->on == Blocked::On::reset && c != kReset) return;
    switch (c) {
        case '?':
            say_status();
            break;
        case '!':
            feed_hold();
            break;
        case '~':
            cycle_start();
            break;
        case kReset:
            reset();
            break;
        case kJogCancel:
            if (state_ == State::jog) planner_.cancel();
            break;
        default:
            handle_override(static_cast<unsigned char>(c));
            break;
    }
}

void GrblMachine::handle_override(unsigned char byte) {
    constexpr unsigned char kFeed = 0x90;     // 100 %, then +10, -10, +1, -1
    constexpr unsigned char kRapid = 0x95;    // 100 %, 50, 25
    constexpr unsigned char kSpindle = 0x99;  // as for the feed
    constexpr unsigned char kFlood = 0xA0;
    constexpr unsigned char kMist = 0xA1;
    static constexpr std::array kSteps{0, 10, -10, 1, -1};
    constexpr std::array kRapids{100, 50, 25};
    const auto change = [](int& percent, int which) {
        percent = which == 0 ? 100 : std::clamp(percent + kSteps.at(static_cast<std::size_t>(which)), 10, 200);
    };
    if (byte >= kFeed && byte < kFeed + kSteps.size()) {
        change(overrides_.feed, byte - kFeed);
    } else if (byte >= kRapid && byte < kRapid + kRapids.size()) {
        overrides_.rapid = kRapids.at(byte - kRapid);
    } else if (byte >= kSpindle && byte < kSpindle + kSteps.size()) {
        change(overrides_.spindle, byte - kSpindle);
    } else if (byte == kFlood) {
        modal_.flood = !modal_.flood;
    } else if (byte == kMist) {
        modal_.mist = !modal_.mist;
    } else {
        return;
    }
    planner_.set_overrides(overrides_);
    status_.overrides_changed();
}

void GrblMachine::feed_hold() {
    if (state_ == State::jog) planner_.cancel();
    if (state_ != State::run && state_ != State::idle) return;
    planner_.hold();
    state_ = State::hold;
}

void GrblMachine::cycle_start() {
    if (state_ != State::hold || !planner_.is_held_at_rest()) return;
    planner_.resume();
    state_ = State::run;
}

void GrblMachine::say(std::string_view line) {
    if (silent_ || link_ != VirtualGrbl::Link::up) return;
    output_.say(line);
    output_.say("\r\n");
}

void GrblMachine::say_status() {
    GrblStatus status;
    switch (state_) {
        case State::idle:
            status.state = "Idle";
            break;
        case State::run:
            status.state = "Run";
            break;
        case State::hold:
            status.state = tool_.is_moving() ? "Hold:1" : "Hold:0";
            break;
        case State::jog:
            status.state = "Jog";
            break;
        case State::home:
            status.state = "Home";
            break;
        case State::alarm:
            status.state = "Alarm";
            break;
        case State::check:
            status.state = "Check";
            break;
    }
    status.moving = state_ == State::run || state_ == State::hold || state_ == State::jog || state_ == State::home;
    status.position = reported_position();
    status.overrides = overrides_;
    status.modal = modal_;
    status.work_offset = frame_.offset(modal_);
    status.speed_mm_per_s = tool_.speed_mm_per_s();
    status.probe_closed = tool_.is_probe_closed();
    status.probe_cut = probe_cut_;
    status.homed = homed_;
    status.planner_free = planner_.free_blocks();
    status.buffer_free = kBufferSize - buffer_.size();
    say(status_.next(status, settings_));
}

Point GrblMachine::reported_position() const {
    using Kind = VirtualFault::Kind;
    const Point p = tool_.position();
    if (!position_fault_) return p;
    if (position_fault_->kind == Kind::position_zero) return Point::Zero();
    if (position_fault_->kind == Kind::position_frozen) return frozen_position_;
    if (position_fault_->kind == Kind::position_swapped) return {p.y(), p.x(), p.z()};
    return p + position_shift_;
}

void GrblMachine::answer(int error) {
    if (error == 0) {
        say("ok");
        return;
    }
    if (options_.dialect == GrblDialect::grblhal) sticky_error_ = error;
    say(fmt::format("error:{}", error));
}

}  // namespace palpate
