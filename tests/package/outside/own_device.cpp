// A touch probe on a machine of one's own, under Palpate's decorators and planner. Here its world is a torus.
#include <palpate/devices/decorators/metered_device.h>
#include <palpate/devices/device_oracle.h>
#include <palpate/planner/probe_surface.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

using palpate::MoveResult;
using palpate::Point;

class TorusProbe final : public palpate::ProbeDevice {
public:
    static constexpr double kError = 1e-6;    // mm: how far beside the torus touches are
    static constexpr double kRetract = 0.05;  // mm: back along the way after a touch

    explicit TorusProbe(const Point& start) : tool_(start) {}

    Point position() const override { return tool_; }

    // Steps that are as long as nothing can be in the way.
    MoveResult guarded_move(const Point& target, palpate::Pace /*pace*/) override {
        const Point start = tool_;
        const double length = (target - start).norm();
        const auto at = [&](double way) -> Point { return start + way / length * (target - start); };
        for (double way = 0; way < length;) {
            const double gap = distance(at(way));
            if (gap < kError) {
                tool_ = at(std::max(way - kRetract, 0.0));
                return {MoveResult::Outcome::contact, at(way)};
            }
            way += gap;
        }
        tool_ = target;
        return {MoveResult::Outcome::reached, target};
    }

    void stop() override {}  // moves take no time

private:
    // mm, of a torus around the z axis: 1 mm from there to the middle of a tube of radius 0.4 mm.
    static double distance(const Point& p) { return std::hypot(std::hypot(p.x(), p.y()) - 1.0, p.z()) - 0.4; }

    Point tool_;
};

int main() {
    TorusProbe probe({0, 0, 3});
    palpate::MotionModel motion;
    motion.retract_mm = TorusProbe::kRetract;
    palpate::MeteredDevice metered(probe, motion);
    palpate::OracleTraits traits;
    traits.touch_error = TorusProbe::kError;
    traits.retract = TorusProbe::kRetract;
    traits.rates = palpate::machine_rates(motion);
    palpate::DeviceOracle oracle(metered, traits);
    palpate::Options options;
    options.epsilon = 0.12;
    options.reach = 0.4;
    const palpate::Result result = palpate::probe_surface(oracle, palpate::Region(palpate::Ball{Point::Zero(), 1.6}), options);

    const palpate::Meter& meter = metered.meter();
    std::printf("%zu samples, %llu moves, %llu contacts, %.0f mm, about %.0f s on a machine. %s\n", result.samples,
                static_cast<unsigned long long>(meter.moves()), static_cast<unsigned long long>(meter.contacts()), meter.displacement_mm,
                meter.machine_time.count(), result.certificate.statement.c_str());
    const bool is_right = result.topology.is_closed_oriented_manifold() && result.topology.euler_characteristic == 0 &&
                          meter.contacts() >= result.samples && meter.faults == 0;
    return is_right ? 0 : 1;
}
