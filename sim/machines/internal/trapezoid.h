// Distance over time of one straight move: speeding up, cruising, slowing down; with an early stop in between if asked for.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "planner/machine_time.h"

namespace palpate {

// mm, mm/s, mm/s². A value: nothing here moves by itself.
class Trapezoid {
public:
    // To rest; a triangle where `length` is too short to reach the feed. From rest, or from a speed that may be above the feed.
    // REQUIRES: length >= 0, feed and acceleration > 0; it can brake within the length.
    Trapezoid(double length, double feed, double acceleration, double speed = 0.0);

    [[nodiscard]] double length() const;
    [[nodiscard]] Seconds duration() const;
    // Before the start and after the end: at rest there.
    [[nodiscard]] double distance(Seconds time) const;
    [[nodiscard]] double speed(Seconds time) const;
    // When it first has come that far, or nothing if it never does.
    [[nodiscard]] std::optional<Seconds> time_at(double distance) const;

    // The same up to `time`, then slowing down to rest. Never goes farther than before, nor takes longer.
    [[nodiscard]] Trapezoid stopped_from(Seconds time) const;

private:
    struct Phase {
        double time = 0.0;          // s
        double speed = 0.0;         // at its start
        double acceleration = 0.0;  // constant during it

        [[nodiscard]] double distance_after(double t) const { return (speed + 0.5 * acceleration * t) * t; }
    };
    static constexpr std::size_t kMostPhases = 4;  // speeding up, cruising, slowing down: an early stop replaces the ones after it

    void append(const Phase& phase);

    std::array<Phase, kMostPhases> phases_;
    std::size_t count_ = 0;
    double acceleration_;
};

}  // namespace palpate
