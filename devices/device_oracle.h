// The planner's SurfaceOracle on any ProbeDevice: every motion, travel too, is a guarded move.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>

#include "devices/probe_device.h"
#include "planner/surface_oracle.h"

namespace palpate {

// A machine is never exactly where the planner wants it: its numbers have a resolution, its touches an error. The planner is told of
// the lines that it asked for, and touches are put on them: all errors are then touches beside S, which it reckons with
// (OracleTraits).
//
// Free space is free up to that error only. A way that S grazes within it is touched although it was proven free; the oracle stops short of
// a place that it cannot quite reach, and passes beside one that it cannot go through, by kGraze errors at most. What it cannot
// pass so is a contradiction.
class DeviceOracle final : public SurfaceOracle {
public:
    // What the device's positions are: off by what its traits say, or a simulation's, exact to rounding whatever machine it stands for.
    enum class Positions { as_traits_say, exact };
    // `device` must outlive the oracle. `proof`: has the probe pressed by hand, and says whether that was seen; empty: nobody can be asked.
    explicit DeviceOracle(ProbeDevice& device, const OracleTraits& traits = {}, Positions positions = Positions::as_traits_say,
                          std::function<bool()> proof = {})
        : device_(device),
          traits_(traits),
          error_(positions == Positions::exact ? 0.0 : traits.touch_error),
          proof_(std::move(proof)),
          position_(device.position()),
          first_(position_) {}

    [[nodiscard]] Point position() const override { return position_; }
    // Throws UnexpectedContact if S is in the way, and DeviceError on a fault.
    void travel(std::span<const Point> path, Ground ground) override;
    // Throws DeviceError on a fault.
    [[nodiscard]] ProbeAnswer probe(const Point& target) override;
    [[nodiscard]] OracleTraits traits() const override { return traits_; }
    [[nodiscard]] bool prove_alive() override { return proof_ && proof_(); }

    // Touches on travel that were passed so.
    [[nodiscard]] std::uint64_t grazes() const { return grazes_; }

    // Of the touch error: how near to a place counts as there, and how far beside a way counts as on it.
    static constexpr double kGraze = 10.0;
    // Of the tool's whole range so far: ways along planar faces, which many samples in one plane make, are as far from where exact
    // arithmetic would have them. Met: 2e-8.
    static constexpr double kRounding = 1e-8;

private:
    MoveResult move(const Point& target, Pace pace);
    void travel_to(const Point& target, Pace pace);
    // mm: how near is there, and beside is on the way.
    [[nodiscard]] double graze() const;
    // To a place just before `touched`, which is `target` as far as touches can tell. False if S is there, too.
    [[nodiscard]] bool stop_short(const Point& touched, const Point& target, Pace pace);
    // Past `touched`, which is on the straight way to `target`: beside it. False if S is there, too.
    [[nodiscard]] bool pass_beside(const Point& touched, const Point& target, Pace pace);

    ProbeDevice& device_;
    const OracleTraits traits_;
    const double error_;  // mm: of positions
    const std::function<bool()> proof_;
    Point position_;  // where the planner has the tool
    const Point first_;
    double range_ = 0.0;  // mm: farthest that the tool was asked to go from there
    std::uint64_t grazes_ = 0;
    std::size_t moves_ = 0;  // since travel to a place began
};

}  // namespace palpate
