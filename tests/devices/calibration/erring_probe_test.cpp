// A probe that errs as real ones do, qualified on a sphere: on what simulates one, and on axes that take time.
#include <gtest/gtest.h>

#include "devices/calibration/probe_qualification.h"
#include "sim/machines/virtual_tool.h"
#include "sim/objects/hidden_object.h"
#include "sim/simulated_device.h"
#include "tests/devices/calibration/sphere_device.h"

namespace palpate::erring_probe_test {
namespace {

const ReferenceSphere kReference{kSaidCenter, kSphere};
const Point kStart = kSaidCenter + Point(5, -3, 30);

// The sphere grown by the ball, where the machine has it.
HiddenObject grown_sphere() {
    ShapeSpec sphere{SphereSpec{(kSphere + kBall) / 2}};
    sphere.at = kSphereCenter;
    return HiddenObject(sphere);
}

// Of an ordinary probe: 40 µm of lobes.
ProbeErrors ordinary_errors() {
    ProbeErrors errors;
    errors.sigma_mm = kSigma;
    errors.lobes_mm = 0.04;
    return errors;
}

// Drives a virtual tool as a controller would: backs off after a touch.
class AxesDevice final : public ProbeDevice {
public:
    AxesDevice(const Obstacle& obstacle, const VirtualToolOptions& options) : tool_(obstacle, options) {}

    [[nodiscard]] Point position() const override { return tool_.position(); }
    [[nodiscard]] MoveResult guarded_move(const Point& target, Pace pace) override {
        const Point start = position();
        const MotionModel& motion = tool_.options().motion;
        tool_.start_move(target, motion.feeds.of(pace), VirtualTool::Guard::until_contact);
        tool_.finish();
        if (!tool_.trigger()) return {MoveResult::Outcome::reached, target};
        const Point touched = *tool_.trigger();
        const Vector back = start - touched;
        tool_.start_move(touched + std::min(1.0, motion.retract_mm / back.norm()) * back, motion.feeds.of(pace), VirtualTool::Guard::none);
        tool_.finish();
        return {MoveResult::Outcome::contact, touched};
    }
    void stop() override {}
    [[nodiscard]] const VirtualToolAudit& audit() const { return tool_.audit(); }

private:
    VirtualTool tool_;
};

void expect_calibrated(const Qualification& q, const ProbeErrors& errors) {
    EXPECT_LE(left_over(q, [&](const Vector& n) { return errors.pretravel(n); }).shape_rms, 0.003);
    EXPECT_NEAR(q.repeatability_mm, kSigma, 0.0004);
    EXPECT_LE(q.form_error_mm, 0.0045);
    EXPECT_GE(q.raw_form_error_mm, 0.03) << "without its map the probe is worth that";
}

TEST(ErringProbe, ASimulatedOneIsCalibratedToAFewSigma) {
    const HiddenObject sphere = grown_sphere();
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        ProbeErrors errors = ordinary_errors();
        errors.seed = seed;
        SimulatedDevice device(sphere, kStart, {.errors = errors});
        expect_calibrated(qualify_probe(device, kReference, test_tool()), errors);
        EXPECT_EQ(device.unsafe_moves(), 0U);
    }
}

TEST(ErringProbe, OneOnAxesThatTakeTimeIsCalibratedToAFewSigma) {
    const HiddenObject sphere = grown_sphere();
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        VirtualToolOptions options;
        options.start = kStart;
        options.errors = ordinary_errors();
        options.errors.seed = seed;
        AxesDevice device(sphere, options);
        expect_calibrated(qualify_probe(device, kReference, test_tool()), options.errors);
        EXPECT_EQ(device.audit().unsafe_moves, 0U);
        EXPECT_EQ(device.audit().outside_limits, 0U);
    }
}

// Bending and a late trigger are part of what is calibrated: the same feed as later.
TEST(ErringProbe, BendingAndLatencyAreCalibratedToo) {
    const HiddenObject sphere = grown_sphere();
    ProbeErrors errors = ordinary_errors();
    errors.trigger_force_n = 0.1;
    errors.compliance_across_mm_per_n = 0.2;
    errors.compliance_along_mm_per_n = 0.002;
    errors.latency = Seconds(0.004);
    SimulatedDevice device(sphere, kStart, {.errors = errors});
    const Qualification q = qualify_probe(device, kReference, test_tool());
    const auto pretravel = [&](const Vector& n) { return errors.pretravel(n) + 0.004 * MotionModel{}.feeds.probe_mm_per_s; };
    EXPECT_LE(left_over(q, pretravel).shape_rms, 0.003);
}

}  // namespace
}  // namespace palpate::erring_probe_test
