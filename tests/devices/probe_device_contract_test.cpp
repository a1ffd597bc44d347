// What the seam promises (devices/probe_device.h), on every device, alone and under every decorator.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "devices/decorators/limited_device.h"
#include "devices/decorators/metered_device.h"
#include "devices/decorators/multi_touch_device.h"
#include "devices/external/external_device.h"
#include "devices/grbl/grbl_device.h"
#include "devices/posix/tcp_stream.h"
#include "sim/machines/external/virtual_program.h"
#include "sim/machines/grbl/loopback_stream.h"
#include "sim/simulated_device.h"
#include "tests/devices/modbus/modbus_support.h"
#include "tests/linuxcnc/fake_linuxcnc.h"
#include "tests/random.h"

namespace palpate::probe_device_contract_test {
namespace {

using Outcome = MoveResult::Outcome;

// Of the tests' world, in the coordinates of the devices.
const Point kStart = test::kStart;
constexpr double kRadius = test::kRadius;  // mm, of a sphere around the origin
const Box kLimits{Point::Constant(-30.0), Point::Constant(30.0)};

struct Cost {
    std::uint64_t unguarded = 0;
    std::uint64_t unsafe = 0;
    std::uint64_t outside = 0;
};

Cost account_of(const VirtualToolAudit& audit) { return {audit.unguarded_moves, audit.unsafe_moves, audit.outside_limits}; }

// --- machines --------------------------------------------------------------------------------------------------------

class SimulatedRig {
public:
    static constexpr double kResolution = 1e-9;  // mm: rounding
    [[nodiscard]] ProbeDevice& device() { return device_; }
    [[nodiscard]] Point tool() { return device_.position(); }
    [[nodiscard]] Cost cost() { return {0, device_.unsafe_moves(), 0}; }

private:
    HiddenObject object_{ShapeSpec{SphereSpec{kRadius}}};
    SimulatedDevice device_{object_, kStart};
};

template <GrblDialect kDialect>
class GrblRig {
public:
    static constexpr double kResolution = 0.001;
    GrblRig() { device_.make_ready(); }
    [[nodiscard]] ProbeDevice& device() { return device_; }
    [[nodiscard]] Point tool() { return tool_.true_position() - test::kOrigin; }
    [[nodiscard]] Cost cost() { return account_of(tool_.audit()); }

private:
    static GrblOptions driver_options() {
        GrblOptions options;
        options.origin = test::kOrigin;
        return options;
    }
    static VirtualGrblOptions machine_options() {
        VirtualGrblOptions options;
        options.dialect = kDialect;
        return options;
    }
    HiddenObject object_{ShapeSpec{SphereSpec{kRadius}}};
    VirtualTool tool_{object_, test::machine_options().tool};
    VirtualGrbl machine_{tool_, machine_options()};
    LoopbackStream stream_{machine_};
    GrblDevice device_{stream_, stream_, driver_options()};
};

template <test::Wire kWire>
class ModbusRig {
public:
    static constexpr double kResolution = 0.001;
    [[nodiscard]] ProbeDevice& device() { return *device_; }
    [[nodiscard]] Point tool() { return machine_.tool(); }
    [[nodiscard]] Cost cost() { return account_of(machine_.audit()); }

private:
    test::Machine machine_{kWire};
    std::unique_ptr<ModbusDevice> device_ = machine_.device();
};

class ExternalRig {
public:
    static constexpr double kResolution = 0.001;
    ExternalRig() { device_.make_ready(); }
    [[nodiscard]] ProbeDevice& device() { return device_; }
    [[nodiscard]] Point tool() {
        Point at;
        program_.with([&](VirtualTool& tool) { at = tool.true_position() - test::kOrigin; });
        return at;
    }
    [[nodiscard]] Cost cost() {
        Cost cost;
        program_.with([&](VirtualTool& tool) { cost = account_of(tool.audit()); });
        return cost;
    }

private:
    static ExternalOptions driver_options() {
        ExternalOptions options;
        options.origin = test::kOrigin;
        return options;
    }
    HiddenObject object_{ShapeSpec{SphereSpec{kRadius}}};
    VirtualTool tool_{object_, test::machine_options().tool};
    VirtualProgram program_{tool_, {}};
    SteadyClock clock_;
    TcpStream stream_{*parse_host_port(program_.address())};
    ExternalDevice device_{stream_, clock_, driver_options()};
};

// LinuxCNC's own bridge, beside a LinuxCNC that is made up.
class LinuxCncRig {
public:
    static constexpr double kResolution = 0.001;
    LinuxCncRig() { device_.make_ready(); }
    [[nodiscard]] ProbeDevice& device() { return device_; }
    [[nodiscard]] Point tool() { return machine_.tool() - test::kOrigin; }
    [[nodiscard]] Cost cost() { return {machine_.unguarded_moves(), 0, 0}; }

private:
    static ExternalOptions driver_options() {
        ExternalOptions options;
        options.origin = test::kOrigin;
        options.silence = Seconds(1);  // of a loaded computer
        return options;
    }
    test::FakeLinuxCnc machine_{test::small_ball(kRadius, test::kOrigin, kStart + test::kOrigin)};
    SteadyClock clock_;
    std::unique_ptr<TcpStream> stream_ = machine_.connect();
    ExternalDevice device_{*stream_, clock_, driver_options()};
};

// --- decorators ------------------------------------------------------------------------------------------------------

template <class Rig>
class Limited : public Rig {
public:
    [[nodiscard]] ProbeDevice& device() { return device_; }

private:
    LimitedDevice device_{Rig::device(), kLimits, Rig::kResolution};
};

template <class Rig>
class Measured : public Rig {
public:
    [[nodiscard]] ProbeDevice& device() { return device_; }

private:
    static MultiTouchOptions options() {
        MultiTouchOptions options;
        options.samples = 3;
        return options;
    }
    MultiTouchDevice device_{Rig::device(), options(), MotionModel{}.retract_mm};
};

template <class Rig>
class Metered : public Rig {
public:
    [[nodiscard]] ProbeDevice& device() { return device_; }

private:
    MeteredDevice device_{Rig::device(), MotionModel{}};
};

// As a session has them.
template <class Rig>
using Session = Metered<Measured<Limited<Rig>>>;

using GrblMachineRig = GrblRig<GrblDialect::grbl>;
using GrblHalRig = GrblRig<GrblDialect::grblhal>;
using TcpRig = ModbusRig<test::Wire::tcp>;
using RtuRig = ModbusRig<test::Wire::rtu>;

template <class Rig>
class ProbeDeviceContract : public testing::Test {
protected:
    ~ProbeDeviceContract() override {
        const Cost cost = rig.cost();
        EXPECT_EQ(cost.unguarded, 0U);
        EXPECT_EQ(cost.unsafe, 0U);
        EXPECT_EQ(cost.outside, 0U);
    }
    MoveResult move(const Point& target, Pace pace = Pace::probe) { return rig.device().guarded_move(target, pace); }
    void expect_near(const Point& p, const Point& q) const { EXPECT_NEAR((p - q).norm(), 0, kDoubt) << p.transpose(); }
    // What the device says is where the tool is.
    void expect_at(const Point& p) {
        expect_near(rig.device().position(), p);
        expect_near(rig.tool(), p);
    }

    // Both ends of a move and a touch are rounded.
    static constexpr double kDoubt = 2 * Rig::kResolution;
    Rig rig;
};

using Rigs = testing::Types<SimulatedRig, Limited<SimulatedRig>, Measured<SimulatedRig>, Metered<SimulatedRig>, Session<SimulatedRig>,
                            GrblMachineRig, Limited<GrblMachineRig>, Measured<GrblMachineRig>, Metered<GrblMachineRig>,
                            Session<GrblMachineRig>, GrblHalRig, Limited<GrblHalRig>, Measured<GrblHalRig>, Metered<GrblHalRig>,
                            Session<GrblHalRig>, TcpRig, Limited<TcpRig>, Measured<TcpRig>, Metered<TcpRig>, Session<TcpRig>, RtuRig,
                            Limited<RtuRig>, Measured<RtuRig>, Metered<RtuRig>, Session<RtuRig>, ExternalRig, Limited<ExternalRig>,
                            Measured<ExternalRig>, Metered<ExternalRig>, Session<ExternalRig>, LinuxCncRig, Session<LinuxCncRig>>;
TYPED_TEST_SUITE(ProbeDeviceContract, Rigs);

TYPED_TEST(ProbeDeviceContract, ADeviceRestsWhereItsToolIs) { this->expect_at(kStart); }

TYPED_TEST(ProbeDeviceContract, AFreeMoveReachesItsTarget) {
    for (const Pace pace : {Pace::travel, Pace::probe, Pace::touch}) {
        const Point target = kStart + (1.0 + static_cast<double>(pace)) * Vector(-0.5127, 0.25, 0.125);
        EXPECT_EQ(this->move(target, pace), (MoveResult{Outcome::reached, target, {}}));
        this->expect_at(target);
    }
}

TYPED_TEST(ProbeDeviceContract, ABlockedMoveTouchesWhereTheSurfaceIs) {
    for (const Pace pace : {Pace::travel, Pace::probe, Pace::touch}) {
        const Point before = (kRadius + 1.5) * Point(3, 1 + static_cast<double>(pace), -1).normalized();
        ASSERT_EQ(this->move(before, Pace::travel).outcome, Outcome::reached);
        const MoveResult result = this->move({0, 0, 0}, pace);
        EXPECT_EQ(result.outcome, Outcome::contact);
        EXPECT_TRUE(result.held);
        EXPECT_TRUE(result.events.empty());
        this->expect_near(result.position, kRadius * before.normalized());
    }
}

TYPED_TEST(ProbeDeviceContract, AfterATouchTheToolRestsOnItsWayNotBehindTheTouchAndCanMoveAway) {
    const Point before(kRadius + 2, 0.4, 0.3);
    ASSERT_EQ(this->move(before, Pace::travel).outcome, Outcome::reached);
    const MoveResult result = this->move({0, 0, 0});
    ASSERT_EQ(result.outcome, Outcome::contact);
    const Point rest = this->rig.device().position();
    this->expect_near(this->rig.tool(), rest);
    const Vector way = -before.normalized();
    const double along = (rest - before).dot(way);
    this->expect_near(rest, before + along * way);
    EXPECT_GE(along, -this->kDoubt);
    EXPECT_LE(along, (result.position - before).dot(way) + this->kDoubt);
    // Along the surface would graze it: outwards at a slant.
    const Point away = rest + 2 * (before.normalized() + Vector(0, 0.6, -0.3));
    EXPECT_EQ(this->move(away, Pace::travel).outcome, Outcome::reached);
    this->expect_at(away);
}

TYPED_TEST(ProbeDeviceContract, AMoveOfNoLengthReaches) {
    const MoveResult result = this->move(this->rig.device().position());
    EXPECT_EQ(result.outcome, Outcome::reached);
    this->expect_at(kStart);
    ASSERT_EQ(this->move({0, 0, 0}).outcome, Outcome::contact);
    const Point rest = this->rig.device().position();
    EXPECT_EQ(this->move(rest).outcome, Outcome::reached);
    this->expect_at(rest);
}

TYPED_TEST(ProbeDeviceContract, TwoTouchesOfOnePlaceAgree) {
    const Point before = (kRadius + 1) * Point(2, -1, 1).normalized();
    ASSERT_EQ(this->move({15, -10, 10}, Pace::travel).outcome, Outcome::reached);
    ASSERT_EQ(this->move(before, Pace::travel).outcome, Outcome::reached);
    const MoveResult first = this->move({0, 0, 0});
    ASSERT_EQ(this->move(before).outcome, Outcome::reached);
    const MoveResult second = this->move({0, 0, 0}, Pace::touch);
    EXPECT_EQ(first.outcome, Outcome::contact);
    EXPECT_EQ(second.outcome, Outcome::contact);
    this->expect_near(first.position, second.position);
}

TYPED_TEST(ProbeDeviceContract, ATargetThatIsNoNumberIsAFaultAndMovesNothing) {
    EXPECT_THROW((void)this->move({20, 0, std::nan("")}), DeviceError);
    this->expect_at(kStart);
    EXPECT_EQ(this->move({20, 1, 0}).outcome, Outcome::reached) << "and it can be worked with";
}

TYPED_TEST(ProbeDeviceContract, ToStopWhatRestsChangesNothing) {
    this->rig.device().stop();
    this->expect_at(kStart);
    EXPECT_EQ(this->move({20, 1, 0}).outcome, Outcome::reached);
}

// The same moves on every device, against the ray of the sphere in closed form.
TYPED_TEST(ProbeDeviceContract, RandomMovesEndWhereTheRayCasterSays) {
    constexpr std::uint64_t kSeed = 4;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    int contacts = 0;
    int reached = 0;
    for (int k = 0; k < 20; ++k) {
        SCOPED_TRACE(k);
        const Point from = this->rig.device().position();
        const Point target = random.in_box(Point::Constant(-9), Point::Constant(9));
        const Vector way = (target - from).normalized();
        const double nearest = -from.dot(way);
        const double beside = (from + nearest * way).norm();
        const double length = (target - from).norm();
        // Rounding decides of what grazes the sphere or ends on it; a tool that runs on through a short chord comes back through its
        // deepest place, which the account takes for unsafe.
        if (std::abs(beside - kRadius) < 0.3 || std::abs(target.norm() - kRadius) < 0.05) continue;
        const double hit = nearest - std::sqrt(std::max(0.0, kRadius * kRadius - beside * beside));
        // A simulated probe may rest on the sphere.
        const bool is_blocked = beside < kRadius && hit > -this->kDoubt && hit < length;
        const MoveResult result = this->move(target, random.chance(0.5) ? Pace::travel : Pace::probe);
        ASSERT_EQ(result.outcome, is_blocked ? Outcome::contact : Outcome::reached);
        // A step beside the way is more than one along it where the surface is met at a slant.
        const double slant = is_blocked ? std::abs(way.dot((from + hit * way).normalized())) : 1.0;
        EXPECT_NEAR((result.position - (is_blocked ? Point(from + hit * way) : target)).norm(), 0, this->kDoubt / slant);
        this->expect_near(this->rig.device().position(), this->rig.tool());
        ++(is_blocked ? contacts : reached);
    }
    EXPECT_GT(contacts, 3);
    EXPECT_GT(reached, 3);
}

}  // namespace
}  // namespace palpate::probe_device_contract_test
