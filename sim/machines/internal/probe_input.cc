#include "sim/machines/internal/probe_input.h"

#include <algorithm>
#include <utility>

#include "planner/random.h"

namespace palpate {

void ProbeInput::touch(bool touching, Seconds now) {
    if (touching == touching_) return;
    const bool before = switch_closed();
    touching_ = touching;
    if (touching) missed_ = draw_miss();
    if (switch_closed() == before) return;
    changes_left_ = 2 * bounces_;
    next_bounce_ = now + kBounce;
}

void ProbeInput::set_miss_share(double share, std::uint64_t seed) {
    miss_share_ = share;
    random_.seed(seed);
}

bool ProbeInput::draw_miss() {
    if (std::exchange(miss_next_, false)) return true;
    return miss_share_ > 0.0 && uniform(random_) < miss_share_;
}

void ProbeInput::pass_until(Seconds now) {
    while (changes_left_ > 0 && next_bounce_ <= now) {
        --changes_left_;
        next_bounce_ += kBounce;
    }
}

bool ProbeInput::is_closed(Seconds now) const {
    if (unplugged_) return false;
    return pressed_ || now < glitch_end_ || switch_closed() != (changes_left_ % 2 == 1);
}

std::optional<Seconds> ProbeInput::next_change(Seconds now) const {
    std::optional<Seconds> next;
    if (now < glitch_end_) next = glitch_end_;
    if (changes_left_ > 0) next = next ? std::min(*next, next_bounce_) : next_bounce_;
    return next;
}

}  // namespace palpate
