#include "devices/calibration/probe_qualification.h"

#include <gtest/gtest.h>

#include "devices/decorators/limited_device.h"
#include "devices/decorators/multi_touch_device.h"
#include "devices/errors.h"
#include "tests/devices/calibration/sphere_device.h"
#include "tests/devices/message_of.h"

namespace palpate::probe_qualification_test {
namespace {

using Outcome = MoveResult::Outcome;

const ReferenceSphere kReference{kSaidCenter, kSphere};
const Point kStart = kSaidCenter + Point(5, -3, 30);

// mm: from the sphere to what of the tool is not its ball; negative: that touches first.
double shaft_gap(const Point& at) {
    const ToolShape tool = test_tool();
    const Point neck = at + tool.stylus->length * tool.axis;
    const double stylus = distance_to({at, neck}, kSphereCenter) - tool.stylus->diameter / 2;
    const double holder = distance_to({neck, neck + tool.holder->length * tool.axis}, kSphereCenter) - tool.holder->diameter / 2;
    return std::min(stylus, holder) - kSphere / 2;
}

// Moves that would end somewhere else than at the sphere, if nothing stopped them, below its equator, or into it from beside; and those
// where the tool ends with more than its ball on the sphere.
int unsafe_moves(const SphereDevice& device) {
    constexpr double kOff = 0.6;  // mm: the centre's error
    constexpr double kOvertravel = 2.0;
    int count = 0;
    for (const auto& move : device.log) {
        const Vector in = kSphereCenter - move.from;
        const double off_line = in.cross((move.target - move.from).normalized()).norm();
        const double depth = (kSphere + kBall) / 2 - distance_to({move.from, move.target}, kSphereCenter);
        const bool is_low = move.target.z() < kSphereCenter.z() - kOff;
        const bool is_deep = depth > 0 && (off_line > kOff || depth > kOvertravel);
        // A ball that is pressed gives way.
        const bool is_pressed = (move.result.position - kSphereCenter).norm() < (kSphere + kBall) / 2 - 0.1;
        if (is_low || is_deep || (!is_pressed && shaft_gap(move.result.position) <= 0)) ++count;
    }
    return count;
}

TEST(ProbeQualification, DrivesAProbeAroundTheSphere) {
    for (const auto& [name, pretravel] : {std::pair<const char*, Pretravel>{"three lobes", three_lobes}, {"measured", measured_lobes}}) {
        SCOPED_TRACE(name);
        SphereDevice device(pretravel, kStart);
        const Qualification q = qualify_probe(device, kReference, test_tool());
        EXPECT_LE(left_over(q, pretravel).shape_rms, 0.003);
        EXPECT_LE(q.form_error_mm, 0.0045);
        EXPECT_LE((q.center - kSphereCenter).norm(), 4 * q.axial_sigma_mm);
        EXPECT_EQ(unsafe_moves(device), 0);
        EXPECT_EQ(device.fast_moves, 0);
        const auto contacts = std::ranges::count_if(device.log, [](const auto& move) { return move.result.outcome == Outcome::contact; });
        EXPECT_EQ(contacts, 5 + 50 + 5 * 4) << "each is one that was planned";
        EXPECT_GT(device.position().z(), kSphereCenter.z() + kSphere / 2 + kBall) << "ends above the pole";
    }
}

// As a session has them: every touch measured again, limits around all of it, and sparks on the way.
TEST(ProbeQualification, DrivesAProbeThroughDecorators) {
    SphereDevice machine(three_lobes, kStart);
    int moves = 0;
    machine.script = [&](const SphereDevice::Move& move, std::optional<double> at) {
        const double length = (move.target - move.from).norm();
        return ++moves % 13 == 0 && length > 1 ? std::optional(0.3 * length) : at;
    };
    const Box limits{kSaidCenter - Vector(20, 20, 1), kSaidCenter + Vector(20, 20, 40)};
    LimitedDevice limited(machine, limits, 0.001);
    MultiTouchDevice device(limited, {.samples = 3}, 0.5);
    const Qualification q = qualify_probe(device, kReference, test_tool());
    EXPECT_LE(left_over(q, three_lobes).shape_rms, 0.003);
    EXPECT_EQ(machine.fast_moves, 0);
    EXPECT_EQ(unsafe_moves(machine), 0);
}

TEST(ProbeQualification, AContactOnTheWayEndsIt) {
    SphereDevice device(three_lobes, kStart);
    device.script = [&](const SphereDevice::Move&, std::optional<double> at) { return device.log.size() == 3 ? std::optional(1.0) : at; };
    try {
        static_cast<void>(touch_sphere(device, kReference, test_tool()));
        ADD_FAILURE() << "nothing was thrown";
    } catch (const UnexpectedContact& contact) {
        EXPECT_EQ(device.log.size(), 4U) << "nothing moves afterwards";
        EXPECT_EQ(contact.where(), device.log.back().result.position);
    }
}

TEST(ProbeQualification, AContactFarBeforeTheSphereEndsIt) {
    SphereDevice device(three_lobes, kStart);
    device.script = [&](const SphereDevice::Move&, std::optional<double> at) { return at ? std::optional(0.2) : at; };
    expect_says(message_of<UnexpectedContact>([&] { static_cast<void>(touch_sphere(device, kReference, test_tool())); }),
                "during the way to the sphere");
    EXPECT_EQ(device.log.back().result.outcome, Outcome::contact);
}

TEST(ProbeQualification, AMissingContactEndsItOnTheWayBack) {
    SphereDevice device(three_lobes, kStart);
    int approaches = 0;
    device.script = [&](const SphereDevice::Move&, std::optional<double> at) { return at && ++approaches == 12 ? std::nullopt : at; };
    expect_says(message_of<DeviceError>([&] { static_cast<void>(touch_sphere(device, kReference, test_tool())); }),
                "the sphere stands elsewhere, or the probe is dead");
    EXPECT_EQ(approaches, 12);
    EXPECT_EQ(device.log.back().target, device.log[device.log.size() - 2].from) << "back where the touch began";
    EXPECT_EQ(unsafe_moves(device), 0);
}

TEST(ProbeQualification, ATouchThatDidNotHoldIsMadeAgain) {
    SphereDevice device(three_lobes, kStart);
    int contacts = 0;
    device.answer = [&](MoveResult& result) {
        if (result.outcome == Outcome::contact && ++contacts % 7 == 0) result.held = false;
    };
    const SphereTouches touches = touch_sphere(device, kReference, test_tool());
    EXPECT_EQ(touches.touches.size(), 50U);
    EXPECT_EQ(contacts - contacts / 7, 75);
    EXPECT_EQ(unsafe_moves(device), 0);
}

TEST(ProbeQualification, TouchesThatCannotBeMeasuredEndIt) {
    SphereDevice device(three_lobes, kStart);
    device.answer = [&](MoveResult& result) {
        if (result.outcome == Outcome::contact) result.outcome = Outcome::failed;
    };
    expect_says(message_of<DeviceError>([&] { static_cast<void>(touch_sphere(device, kReference, test_tool())); }),
                "the probe triggers and lets go; look at its wiring");
    EXPECT_EQ(unsafe_moves(device), 0);
}

TEST(ProbeQualification, AWrongDiameterIsFoundOutAfterFiveTouches) {
    SphereDevice device(three_lobes, kStart);
    device.diameter = kSphere + 0.8;
    expect_says(message_of<QualificationError>([&] { static_cast<void>(touch_sphere(device, kReference, test_tool())); }),
                "give those that they have");
    const auto contacts = std::ranges::count_if(device.log, [](const auto& move) { return move.result.outcome == Outcome::contact; });
    EXPECT_EQ(contacts, 5);
}

TEST(ProbeQualification, NothingMovesOnSettingsThatMakeNoSense) {
    SphereDevice device(three_lobes, kStart);
    const auto message = [&](const QualificationSettings& settings) {
        return message_of<QualificationError>([&] { static_cast<void>(touch_sphere(device, kReference, test_tool(), settings)); });
    };
    QualificationSettings settings;
    settings.directions = 24;
    expect_says(message(settings), "24 directions: 25 to 50 can be touched");
    settings = {};
    settings.repeats = 1;
    expect_says(message(settings), "touched twice at least");
    settings = {};
    settings.overtravel_mm = 1.0;
    expect_says(message(settings), "a dead probe would be pressed 1.90 mm into the sphere, its overtravel is 1.00 mm");
    settings = {};
    settings.margins.clearance_mm = 0.5;
    expect_says(message(settings), "the clearance around the sphere");
    settings = {};
    settings.resolution_mm = 0;
    expect_says(message(settings), "resolution has to be positive");
    EXPECT_TRUE(device.log.empty());
}

// On a machine's grid repeated touches of an exact probe are all the same.
TEST(ProbeQualification, ARepeatabilityThatTheGridHidesRefusesNoMap) {
    Random random(31);
    const auto on_grid = [](Point p) {
        for (double& x : p) x = std::round(x * 1000) / 1000;
        return p;
    };
    SphereTouches touches = synthetic_touches(three_lobes, 0, qualification_directions(Vector::UnitZ(), 37), random);
    for (SphereTouch& touch : touches.touches) touch.position = on_grid(touch.position);
    for (auto& group : touches.repeats) {
        for (SphereTouch& touch : group) touch.position = on_grid(touch.position);
    }
    const Qualification q = qualify(touches, kReference, Vector::UnitZ(), 0.001);
    EXPECT_LT(q.repeatability_mm, 1e-9);
    EXPECT_LE(left_over(q, three_lobes).shape_rms, 0.003);
}

}  // namespace
}  // namespace palpate::probe_qualification_test
