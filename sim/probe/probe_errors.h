// What a real probe and its machine get wrong, for those that are simulated: values, and what is drawn from them. Knows no obstacle and no
// device; sim/simulated_device.h and sim/machines/virtual_tool.h suffer it.
//
// Notation: d the direction of a move, n the surface's outward normal where it touches, a the stylus' axis (from the ball to the holder),
// s = sin of the angle between n and a.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <random>

#include "devices/calibration/lobing_map.h"
#include "planner/geometry.h"
#include "planner/machine_time.h"

namespace palpate {

// All zero: none. Nothing is drawn for what is zero, and each kind is drawn by itself: one does not change another.
struct ProbeErrors {
    // Where the probe triggers, along the way.
    double sigma_mm = 0.0;  // >= 0: standard deviation of repeated touches, Gaussian
    Seconds latency{0.0};   // >= 0: triggers are read so late, and the tool goes on meanwhile
    // Pre-travel: so far beyond the first contact the probe triggers, along n.
    double lobes_mm = 0.0;                                        // >= 0: range of three lobes across the axis: from that to twice that
    std::array<double, LobingMap::kCoefficients> harmonics_mm{};  // less that much: LobingMap's coefficients
    double trigger_force_n = 0.0;                                 // >= 0: by which the stylus bends
    double compliance_across_mm_per_n = 0.0;                      // >= 0: where n is across the axis
    double compliance_along_mm_per_n = 0.0;                       // >= 0: where it is along the axis
    // Where the tool is, less what the machine says.
    Vector backlash_mm = Vector::Zero();  // >= 0: an axis that goes down is that much too high
    Vector drift_mm_per_hour = Vector::Zero();
    Vector drift_mm_per_1000_touches = Vector::Zero();
    Vector swing_mm = Vector::Zero();  // amplitude of a drift to and fro, as of a hall's temperature
    Seconds swing_period{3600.0};      // > 0
    // Of the moves that a contact ends or would: shares, 0 to 1.
    double false_triggers = 0.0;  // trigger where nothing is, anywhere on the way
    double misses = 0.0;          // do not notice a contact
    double bounces = 0.0;         // open and close again around it: of virtual machines only

    Vector axis = Vector::UnitZ();  // a: unit
    std::uint64_t seed = 1;

    // Whether there are any.
    [[nodiscard]] bool is_any() const;
    // mm along n: of pre-travel.
    [[nodiscard]] double pretravel(const Vector& normal) const;
    // mm along the way: of the same, where S is flat: a tool at a slant goes that much farther for it. `slope`: the sine of the angle
    // between the way and S; kLeastSlope bounds it.
    [[nodiscard]] double pretravel(const Vector& normal, double slope) const { return pretravel(normal) / std::max(kLeastSlope, slope); }
    static constexpr double kLeastSlope = 0.1;
    // mm: how far beside S touches may lie at that feed, as a planner is told: 4 sigma, the greatest pre-travel, what latency, backlash and
    // swing amount to, and the drift of an hour and a thousand touches. False triggers are not among it.
    [[nodiscard]] double touch_error(double feed_mm_per_s) const;
    // mm: after that time and so many touches.
    [[nodiscard]] Vector drift_at(Seconds time, std::uint64_t touches) const;

    // Standard deviations that touch_error() counts: more in 1 of 16000 touches.
    static constexpr double kSigmas = 4.0;
};

// What chance adds. The same seed gives the same numbers.
class ProbeErrorDraws {
public:
    explicit ProbeErrorDraws(const ProbeErrors& errors);

    // mm along the way from the first contact to the trigger, without latency; negative: before it.
    [[nodiscard]] double lateness(const Vector& direction, const Vector& normal);
    [[nodiscard]] bool misses();
    [[nodiscard]] bool bounces();
    // Share of the move's way or time after which it triggers falsely.
    [[nodiscard]] std::optional<double> false_trigger();

    [[nodiscard]] const ProbeErrors& errors() const { return errors_; }

private:
    [[nodiscard]] double gaussian();

    ProbeErrors errors_;
    std::mt19937_64 touches_;
    std::mt19937_64 misses_;
    std::mt19937_64 bounces_;
    std::mt19937_64 false_triggers_;
};

}  // namespace palpate
