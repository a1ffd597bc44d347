// Counts what passes through to a device: moves, events, displacement, and about how long a machine takes for it.
#pragma once

#include <array>
#include <cstdint>

#include "devices/motion_model.h"
#include "devices/probe_device.h"
#include "planner/machine_time.h"

namespace palpate {

struct MoveCount {
    std::uint64_t reached = 0;
    std::uint64_t contact = 0;
    std::uint64_t failed = 0;
    std::uint64_t vanished = 0;

    [[nodiscard]] std::uint64_t& of(MoveResult::Outcome outcome);
    [[nodiscard]] std::uint64_t total() const { return reached + contact + failed + vanished; }
    friend bool operator==(const MoveCount&, const MoveCount&) = default;
};

struct Meter {
    MoveCount travel;
    MoveCount probe;
    MoveCount touch;
    std::uint64_t faults = 0;               // moves that threw: counted here only, as nobody knows how far they went
    std::array<std::uint64_t, 4> events{};  // by DeviceEvent::Kind
    double displacement_mm = 0.0;           // the way into a touch and back from it included; running on after it is not
    Seconds machine_time{0.0};              // estimate

    [[nodiscard]] MoveCount& of(Pace pace) { return pace == Pace::travel ? travel : pace == Pace::probe ? probe : touch; }
    [[nodiscard]] std::uint64_t count(DeviceEvent::Kind kind) const { return events.at(static_cast<std::size_t>(kind)); }
    [[nodiscard]] std::uint64_t moves() const { return travel.total() + probe.total() + touch.total(); }
    [[nodiscard]] std::uint64_t contacts() const { return travel.contact + probe.contact + touch.contact; }
};

// What a machine takes for a move from `start` that ended so, at `rest`.
[[nodiscard]] Seconds time_of_move(const MotionModel& motion, const Point& start, const MoveResult& result, const Point& rest, Pace pace);

// What is asked for below this, such as the slow touches of a MultiTouchDevice, is seen only by a meter that is below, too.
//
// Time: every move from rest to rest at the feed of its pace. One that ends at a touch runs on by the stopping distance, in which the
// latency is, and goes back from there to where the tool rests, at the probing feed. A device that rests on the touched point stands for a
// machine that does not: it is given the retract of `motion`, there and back.
class MeteredDevice final : public ProbeDevice {
public:
    // `device` must outlive this.
    MeteredDevice(ProbeDevice& device, const MotionModel& motion) : device_(device), motion_(motion) {}

    [[nodiscard]] Point position() const override { return device_.position(); }
    [[nodiscard]] MoveResult guarded_move(const Point& target, Pace pace) override;
    void stop() override { device_.stop(); }

    [[nodiscard]] const Meter& meter() const { return meter_; }

private:
    void add(const Point& start, const MoveResult& result, const Point& rest, Pace pace);

    ProbeDevice& device_;
    const MotionModel motion_;
    Meter meter_;
};

}  // namespace palpate
