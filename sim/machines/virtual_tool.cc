#include "sim/machines/virtual_tool.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "planner/random.h"
#include "sim/machines/internal/probe_input.h"
#include "sim/machines/internal/tool_motion.h"
#include "sim/probe/axis_play.h"

namespace palpate {
namespace {

// mm: rounding of lengths and positions is far less.
constexpr double kArrived = 1e-9;

}  // namespace

VirtualTool::VirtualTool(const Obstacle& obstacle, const VirtualToolOptions& options)
    : obstacle_(obstacle),
      options_(options),
      input_(std::make_unique<ProbeInput>()),
      noise_(options.touch_noise_seed),
      place_(options.start - options.origin) {
    if (options.errors.is_any()) errors_.emplace(options.errors);
    if (options.errors.misses > 0.0) input_->set_miss_share(options.errors.misses, options.errors.seed + 1);
    input_->touch(obstacle_.contains(place_), now_);
}

VirtualTool::~VirtualTool() = default;
VirtualTool::VirtualTool(VirtualTool&&) noexcept = default;

void VirtualTool::start_move(const Point& target, double feed_mm_per_s, Guard guard) {
    assert(!motion_ && feed_mm_per_s > 0.0 && target.allFinite());
    trigger_.reset();
    if (errors_) {  // what drifted while it rested
        place_ += drift() - drift_;
        drift_ = drift();
    }
    const Vector reach = steps_to(target);
    const double length = reach.norm();
    const Vector direction = length > 0.0 ? Vector(reach / length) : Vector::Zero();
    Legs legs = legs_along(reach, target);
    const Trapezoid profile(length, feed_mm_per_s, options_.motion.acceleration_mm_per_s2);
    std::vector<Stretch> stretches = stretches_of(obstacle_, legs);
    motion_ = std::make_unique<ToolMotion>(
        ToolMotion{std::move(legs), length, direction, profile, feed_mm_per_s, guard, now_, std::move(stretches)});
    if (guard == Guard::until_contact) motion_->late = draw_noise();
    motion_->felt = motion_->stretches;
    if (errors_ && length > 0.0) draw_errors();
    // A tool that rests on S lets go of it as it begins to move away.
    if (length > 0.0) input_->touch(motion_->felt.front().inside, now_);
    watch(0.0);
    if (length == 0.0) motion_.reset();
}

Vector VirtualTool::steps_to(const Point& target) const {
    const Vector reach = target + slip_ - options_.origin - place_;
    if (!errors_) return reach;
    // What rounding makes of adding and taking away is no step, and turns no axis.
    return (reach + shift()).unaryExpr([](double step) { return std::abs(step) < kArrived ? 0.0 : step; });
}

std::vector<Leg> VirtualTool::legs_along(const Vector& steps, const Point& target) const {
    const double length = steps.norm();
    const auto rate_of = [](const Vector& change, double mm) { return mm > 0.0 ? Vector(change / mm) : Vector::Zero(); };
    if (!errors_) return {{0.0, length, {place_, target + slip_ - options_.origin}, rate_of(steps, length)}};
    const std::vector<PlayAt> plays = play_along(steps, play_, options_.errors.backlash_mm);
    std::vector<Leg> legs;
    Point begin = place_;
    for (std::size_t k = 1; k < plays.size(); ++k) {
        const PlayAt& before = plays[k - 1];
        const PlayAt& after = plays[k];
        const Point end = place_ + after.share * steps + (after.play - play_);
        const double from = before.share * length;
        const double to = after.share * length;
        legs.push_back(
            {from, to, {begin, end}, rate_of(end - begin, to - from), before.play + drift_, rate_of(after.play - before.play, to - from)});
        begin = end;
    }
    return legs;
}

// Of the move that begins.
void VirtualTool::draw_errors() {
    if (motion_->guard != Guard::none && options_.errors.bounces > 0.0) input_->set_bounces(errors_->bounces() ? 1 : 0);
    double late = 0.0;
    if (motion_->guard == Guard::until_contact) {
        if (const auto share = errors_->false_trigger()) motion_->spark = now_ + *share * motion_->profile.duration();
        late = lateness();
    } else if (is_pressed_open()) {
        late = std::numeric_limits<double>::infinity();
    }
    motion_->felt = felt_of(std::move(motion_->felt), late, earliness());
}

double VirtualTool::earliness() const {
    const std::vector<Stretch>& stretches = motion_->stretches;
    const auto entry = std::ranges::find_if(stretches, [](const Stretch& s) { return s.inside; });
    if (entry == stretches.end()) return 0.0;
    if (entry + 1 == stretches.end()) return entry == stretches.begin() && input_->is_touching() ? easing() : 0.0;
    const Vector normal = obstacle_.normal(motion_->at(entry->to), -motion_->direction);
    return std::max(0.0, options_.errors.pretravel(normal, motion_->direction.dot(normal)));
}

double VirtualTool::easing() const {
    const double length = motion_->whole();
    const auto depth = [&](double distance) { return obstacle_.depth(motion_->at(distance)); };
    constexpr double kStep = 1e-4;  // mm: tells where it is deeper
    const Point end = motion_->target();
    Vector inwards;
    for (int i = 0; i < 3; ++i)
        inwards[i] = obstacle_.depth(end + kStep * Vector::Unit(i)) - obstacle_.depth(end - kStep * Vector::Unit(i));
    if (inwards.isZero(0)) return 0.0;
    const double pressed = options_.errors.pretravel(-inwards.normalized());
    if (depth(length) >= pressed) return 0.0;
    double closed = 0.0;
    double open = length;
    if (depth(0.0) < pressed) return length;
    while (open - closed > kArrived) {
        const double middle = 0.5 * (closed + open);
        (depth(middle) < pressed ? open : closed) = middle;
    }
    return length - open;
}

// It touches, and was not pressed so far that the probe closed.
bool VirtualTool::is_pressed_open() const {
    return motion_->stretches.front().inside && !input_->is_touching() && obstacle_.depth(place_) <= options_.errors.touch_error(0.0);
}

double VirtualTool::lateness() {
    const std::vector<Stretch>& stretches = motion_->stretches;
    const Vector& direction = motion_->direction;
    if (stretches.front().inside) {
        if (!is_pressed_open()) return 0.0;
        constexpr double kStep = 1e-4;  // mm: tells where it is deeper
        const bool is_deeper = obstacle_.depth(place_ + kStep * direction) > obstacle_.depth(place_);
        return is_deeper ? std::max(0.0, errors_->lateness(direction, -direction)) : std::numeric_limits<double>::infinity();
    }
    const auto entry = std::ranges::find_if(stretches, [](const Stretch& s) { return s.inside; });
    return entry == stretches.end() ? 0.0 : errors_->lateness(direction, obstacle_.normal(motion_->at(entry->from), direction));
}

Vector VirtualTool::drift() const { return options_.errors.drift_at(now_, touches_); }

Vector VirtualTool::shift() const {
    if (!errors_) return Vector::Zero();
    return motion_ ? motion_->shift_at(motion_->travelled(now_)) : Vector(play_ + drift_);
}

void VirtualTool::decelerate() {
    if (!motion_) return;
    motion_->profile = motion_->profile.stopped_from(now_ - motion_->start);
    motion_->is_stopping = true;
}

void VirtualTool::change_feed(double feed_mm_per_s) {
    assert(feed_mm_per_s > 0.0);
    if (!motion_ || motion_->is_stopping) return;
    const double travelled = motion_->travelled(now_);
    const double left = std::max(0.0, motion_->whole() - travelled);
    motion_->profile = Trapezoid(left, feed_mm_per_s, options_.motion.acceleration_mm_per_s2, speed_mm_per_s());
    motion_->base = travelled;
    motion_->start = now_;
    motion_->feed_mm_per_s = std::max(motion_->feed_mm_per_s, feed_mm_per_s);
}

void VirtualTool::abort() {
    if (!motion_) return;
    const double speed = speed_mm_per_s();
    const double travelled = motion_->travelled(now_);
    // A profile never asks for harder braking than this, so the mass stays on the way.
    const double run_on = std::min(speed * speed / (2 * options_.motion.acceleration_mm_per_s2), motion_->whole() - travelled);
    slip_ += run_on * motion_->direction;
    end_motion(travelled + run_on);
    input_->touch(obstacle_.contains(place_), now_);
}

void VirtualTool::advance(Seconds time) {
    const Seconds end = now_ + time;
    for (auto next = next_event(); next && *next <= end; next = next_event()) {
        now_ = std::max(now_, *next);
        handle_events();
    }
    now_ = std::max(now_, end);
}

Seconds VirtualTool::finish() {
    const Seconds begin = now_;
    while (motion_) {
        now_ = std::max(now_, *next_event());
        handle_events();
    }
    return now_ - begin;
}

void VirtualTool::place(const Point& position) {
    assert(!motion_);
    slip_ = Vector::Zero();
    play_ = Vector::Zero();
    drift_ = errors_ ? drift() : Vector::Zero();
    place_ = position - options_.origin + drift_;
    input_->touch(obstacle_.contains(place_), now_);
}

void VirtualTool::count_from(const Point& position) {
    assert(!motion_);
    slip_ = true_position() - shift() - position;
}

double VirtualTool::speed_mm_per_s() const { return motion_ ? motion_->profile.speed(now_ - motion_->start) : 0.0; }

Point VirtualTool::true_position() const { return (motion_ ? motion_->at(motion_->travelled(now_)) : place_) + options_.origin; }

Point VirtualTool::rounded(const Point& p) const {
    const double steps_per_mm = 1.0 / options_.motion.resolution_mm;
    return (p * steps_per_mm).array().round() / steps_per_mm;
}

Point VirtualTool::position() const { return rounded(true_position() - slip_ - shift()); }

bool VirtualTool::is_probe_closed() const { return input_->is_closed(now_); }

std::optional<Point> VirtualTool::trigger() const { return trigger_ ? std::optional(rounded(*trigger_)) : std::nullopt; }

std::optional<Seconds> VirtualTool::next_event() const {
    std::optional<Seconds> next = input_->next_change(now_);
    const auto consider = [&](const std::optional<Seconds>& time) {
        if (time) next = next ? std::min(*next, *time) : time;
    };
    if (motion_) {
        consider(motion_->end());
        consider(motion_->slow_down);
        consider(motion_->spark);
        consider(motion_->next_crossing());
    }
    return next;
}

std::optional<Seconds> VirtualTool::time_to_event() const {
    const auto next = next_event();
    return next ? std::optional(std::max(Seconds(0.0), *next - now_)) : std::nullopt;
}

void VirtualTool::handle_events() {
    input_->pass_until(now_);
    if (!motion_) return;
    double distance = motion_->travelled(now_);
    if (motion_->spark && *motion_->spark <= now_) {
        motion_->spark.reset();
        input_->glitch(now_);
    }
    if (const auto crossing = motion_->next_crossing(); crossing && *crossing <= now_) {
        distance = motion_->next_change();  // not what rounding of times makes of it
        input_->touch(motion_->felt[++motion_->stretch].inside, now_);
    }
    watch(distance);
    if (motion_->slow_down && *motion_->slow_down <= now_) {
        motion_->slow_down.reset();
        decelerate();
    }
    if (!motion_->next_crossing() && motion_->end() <= now_) end_motion(motion_->end_distance());
}

void VirtualTool::watch(double distance) {
    if (trigger_ || motion_->guard == Guard::none) return;
    if (is_probe_closed() != (motion_->guard == Guard::until_contact)) return;
    const Seconds late = options_.errors.latency;
    const double read = late.count() > 0.0 ? std::max(distance, motion_->travelled(now_ + late)) : distance;
    trigger_ = motion_->at(read) + options_.origin - slip_ - (errors_ ? motion_->shift_at(read) : Vector::Zero());
    motion_->slow_down = now_ + late + options_.motion.latency;
}

void VirtualTool::end_motion(double distance) {
    const auto motion = std::exchange(motion_, nullptr);
    place_ = std::abs(motion->whole() - distance) < kArrived ? motion->target() : motion->at(distance);
    if (errors_) {
        play_ = motion->shift_at(distance) - drift_;
        if (motion->guard == Guard::until_contact && trigger_) ++touches_;
    }
    record(*motion, distance);
}

void VirtualTool::record(const ToolMotion& motion, double distance) {
    // Depths told to a sixteenth of the overtravel are told well enough.
    const double step = std::max(options_.motion.overtravel_mm, options_.motion.resolution_mm) / 16;
    double deepest = 0.0;
    for (const Stretch& stretch : motion.stretches) {
        if (!stretch.inside || stretch.from >= distance) continue;
        deepest = std::max(deepest, deepest_between(obstacle_, motion.legs, stretch.from, std::min(stretch.to, distance), step));
    }
    ++audit_.moves;
    audit_.distance_mm += distance;
    audit_.deepest_mm = std::max(audit_.deepest_mm, deepest);
    audit_.deepest_end_mm = std::max(audit_.deepest_end_mm, obstacle_.depth(place_));
    if (is_fast(motion) && is_too_deep(deepest)) ++audit_.fast_moves_inside;
    if (motion.guard == Guard::none) ++audit_.unguarded_moves;
    if (is_unsafe(motion, distance, deepest)) ++audit_.unsafe_moves;
    tell(motion, distance);
    const Point end = place_ + options_.origin;
    if (!options_.limits.contains(end, options_.motion.resolution_mm)) ++audit_.outside_limits;
}

void VirtualTool::tell(const ToolMotion& motion, double distance) const {
    if (!options_.on_move) return;
    const Leg& last = leg_at(motion.legs, distance);
    for (const Leg& leg : motion.legs) {
        if (&leg == &last) break;
        options_.on_move(leg.way, false);
    }
    options_.on_move({last.way.source, place_}, motion.guard == Guard::until_contact && trigger_);
}

double VirtualTool::draw_noise() {
    if (options_.touch_noise_mm == 0.0) return 0.0;
    // The same on every platform, which std::uniform_real_distribution is not.
    return options_.touch_noise_mm * (2 * uniform(noise_) - 1);
}

bool VirtualTool::is_too_deep(double depth) const { return depth > options_.motion.overtravel_mm + options_.motion.resolution_mm; }

bool VirtualTool::is_fast(const ToolMotion& motion) const {
    constexpr double kRounding = 1.001;  // of a feed in whole mm/min
    return options_.probe_feed_mm_per_s > 0.0 && motion.feed_mm_per_s > kRounding * options_.probe_feed_mm_per_s;
}

bool VirtualTool::is_unsafe(const ToolMotion& motion, double distance, double deepest) const {
    const double resolution = options_.motion.resolution_mm;
    const double begin = obstacle_.depth(motion.source());
    // Axes that turn take up their play one before the other, so that a tool in touch may be dragged along by it.
    const double drag = begin > 0.0 ? options_.errors.backlash_mm.norm() : 0.0;
    const bool deeper = deepest > begin + drag + resolution;
    if (motion.guard == Guard::until_contact) return deeper && is_too_deep(deepest);
    const auto enters = [&](const Stretch& stretch) {
        return stretch.inside && stretch.from > 0.0 && stretch.from < distance &&
               deepest_between(obstacle_, motion.legs, stretch.from, std::min(stretch.to, distance), resolution) > resolution;
    };
    return deeper || std::ranges::any_of(motion.stretches, enters);
}

void VirtualTool::trigger_spuriously() {
    input_->glitch(now_);
    watch_now();
}

void VirtualTool::watch_now() {
    if (motion_) watch(motion_->travelled(now_));
}

void VirtualTool::miss_next_trigger() { input_->miss_next(); }
void VirtualTool::set_miss_share(double share, std::uint64_t seed) { input_->set_miss_share(share, seed); }

void VirtualTool::set_unplugged(bool unplugged) {
    input_->set_unplugged(unplugged);
    watch_now();
}

void VirtualTool::press(bool pressed) {
    input_->press(pressed);
    watch_now();
}

void VirtualTool::bounce(int times) { input_->set_bounces(times); }

}  // namespace palpate
