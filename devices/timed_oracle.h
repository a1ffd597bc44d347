// How long an oracle thinks, so that the planner's own time can be told.
#pragma once

#include <chrono>
#include <span>

#include "planner/machine_time.h"
#include "planner/surface_oracle.h"

namespace palpate {

// Adds to `total` for as long as it lives.
class Stopwatch {
public:
    explicit Stopwatch(Seconds& total) : total_(total) {}
    ~Stopwatch() { total_ += std::chrono::steady_clock::now() - start_; }
    Stopwatch(const Stopwatch&) = delete;
    Stopwatch& operator=(const Stopwatch&) = delete;

private:
    Seconds& total_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

class TimedOracle final : public SurfaceOracle {
public:
    explicit TimedOracle(SurfaceOracle& oracle) : oracle_(oracle) {}

    [[nodiscard]] Point position() const override { return oracle_.position(); }
    void travel(std::span<const Point> path, Ground ground) override {
        const Stopwatch watch(spent_);
        oracle_.travel(path, ground);
    }
    [[nodiscard]] ProbeAnswer probe(const Point& target) override {
        const Stopwatch watch(spent_);
        return oracle_.probe(target);
    }
    [[nodiscard]] OracleTraits traits() const override { return oracle_.traits(); }
    [[nodiscard]] bool prove_alive() override { return oracle_.prove_alive(); }
    [[nodiscard]] Seconds spent() const { return spent_; }

private:
    SurfaceOracle& oracle_;
    Seconds spent_{0};
};

}  // namespace palpate
