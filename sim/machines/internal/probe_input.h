// What a controller reads at its probe input: the switch of the probe, and all that goes wrong with it.
#pragma once

#include <cstdint>
#include <optional>
#include <random>

#include "planner/machine_time.h"

namespace palpate {

// Times count from any fixed moment and never fall from one call to the next.
class ProbeInput {
public:
    // The stylus touches or leaves the solid.
    void touch(bool touching, Seconds now);
    [[nodiscard]] bool is_touching() const { return touching_; }
    // Lets bounces pass whose time has come.
    void pass_until(Seconds now);
    [[nodiscard]] bool is_closed(Seconds now) const;
    // When is_closed may change by itself: a bounce, or the end of a glitch.
    [[nodiscard]] std::optional<Seconds> next_change(Seconds now) const;

    void glitch(Seconds now) { glitch_end_ = now + kGlitch; }
    void miss_next() { miss_next_ = true; }
    // That share of the touches, 0 to 1, does not close the switch.
    void set_miss_share(double share, std::uint64_t seed);
    // Closed by hand, whatever the stylus does.
    void press(bool pressed) { pressed_ = pressed; }
    void set_unplugged(bool unplugged) { unplugged_ = unplugged; }
    void set_bounces(int times) { bounces_ = times; }

    // Of electrical noise on a long lead: longer than a controller's sampling, shorter than any touch.
    static constexpr Seconds kGlitch{0.005};
    // From one change of a bouncing contact to the next: slow for a switch, so that it outlasts a stop.
    static constexpr Seconds kBounce{0.010};

private:
    [[nodiscard]] bool switch_closed() const { return touching_ && !missed_; }
    [[nodiscard]] bool draw_miss();

    bool touching_ = false;
    bool missed_ = false;  // this touch does not close the switch
    bool miss_next_ = false;
    double miss_share_ = 0.0;
    std::mt19937_64 random_;
    bool pressed_ = false;
    bool unplugged_ = false;
    int bounces_ = 0;
    int changes_left_ = 0;  // odd: the input shows the opposite of the switch
    Seconds next_bounce_{0.0};
    Seconds glitch_end_{0.0};
};

}  // namespace palpate
