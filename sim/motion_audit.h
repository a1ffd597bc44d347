// Independent account of a simulated tool's motion: how far, how often, and did it ever enter the solid.
#pragma once

#include <cstdint>

#include "sim/objects/obstacle.h"

namespace palpate {

// Uses crossings and contains, not the first hit that the device stops at, so that an error there shows.
class MotionAudit {
public:
    // With `check` off it measures only; unsafe_moves() stays 0. `obstacle` must outlive the audit.
    explicit MotionAudit(const Obstacle& obstacle, bool check = true) : obstacle_(obstacle), check_(check) {}

    // A straight move that was carried out.
    void record(const Segment& move);

    [[nodiscard]] std::uint64_t moves() const { return moves_; }
    [[nodiscard]] double distance() const { return distance_; }  // mm
    // Moves that started in the solid or entered it, deeper than kDepth.
    [[nodiscard]] std::uint64_t unsafe_moves() const { return unsafe_moves_; }

    // Share of the obstacle's scale. A move may end on S, and a graze of S runs inside it by rounding; 1e-9 is far above rounding
    // (1e-15) and far below anything that a machine resolves (1 nm on a metre).
    static constexpr double kDepth = 1e-9;

private:
    [[nodiscard]] bool deep(const Point& p) const;
    [[nodiscard]] bool enters(const Segment& move) const;

    const Obstacle& obstacle_;
    bool check_;
    std::uint64_t moves_ = 0;
    std::uint64_t unsafe_moves_ = 0;
    double distance_ = 0.0;
};

}  // namespace palpate
