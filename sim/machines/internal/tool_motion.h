// One straight move of a virtual tool on its way.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "sim/machines/internal/tool_path.h"
#include "sim/machines/internal/trapezoid.h"
#include "sim/machines/virtual_tool.h"

namespace palpate {

// Times are those of the tool.
struct ToolMotion {
    Legs legs;            // where it really goes
    double length = 0.0;  // mm: of the way, by the steps
    Vector direction;     // by the steps: of length 1, or 0 where the way has none
    Trapezoid profile;
    double feed_mm_per_s = 0.0;  // the greatest that it was commanded at
    VirtualTool::Guard guard = VirtualTool::Guard::none;
    Seconds start{0.0};  // of the profile
    std::vector<Stretch> stretches{};
    std::vector<Stretch> felt{};  // the same, as the probe shows them: with errors it closes later or earlier, or not at all
    std::size_t stretch = 0;      // of these, in which it is now
    std::optional<Seconds> slow_down{};
    double base = 0.0;  // mm: of the way, where the profile begins
    bool is_stopping = false;
    double late = 0.0;               // mm: so far behind the surface the probe closes
    std::optional<Seconds> spark{};  // when it closes falsely

    [[nodiscard]] double whole() const { return length; }
    [[nodiscard]] double travelled(Seconds now) const { return base + profile.distance(now - start); }
    [[nodiscard]] double end_distance() const { return base + profile.length(); }
    [[nodiscard]] Point source() const { return legs.front().way.source; }
    [[nodiscard]] Point target() const { return legs.back().way.target; }
    [[nodiscard]] Point at(double distance) const { return leg_at(legs, distance).at(distance); }
    [[nodiscard]] Vector shift_at(double distance) const { return leg_at(legs, distance).shift_at(distance); }
    [[nodiscard]] Seconds end() const { return start + profile.duration(); }
    // Where the probe changes the next time, if there is another stretch.
    [[nodiscard]] double next_change() const {
        const Stretch& next = felt[stretch + 1];
        return next.inside ? std::clamp(next.from + late, felt[stretch].from, next.to) : next.from;
    }
    // When it comes there, if it comes that far.
    [[nodiscard]] std::optional<Seconds> next_crossing() const {
        if (stretch + 1 >= felt.size()) return std::nullopt;
        // What lies at the target is reached, whatever rounding makes of a profile's length.
        constexpr double kRounding = 1e-9;  // mm: far more
        const double at = next_change() - base;
        const double end = profile.length();
        const auto time = profile.time_at(at > end && at - end < kRounding ? end : at);
        return time ? std::optional(start + *time) : std::nullopt;
    }
};

}  // namespace palpate
