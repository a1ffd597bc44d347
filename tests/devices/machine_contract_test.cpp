// What the seam promises (devices/machine.h), on every driver.
#include <gtest/gtest.h>

#include "devices/external/external_machine.h"
#include "devices/grbl/stream_grbl_machine.h"
#include "devices/machine.h"
#include "devices/modbus/modbus_machine.h"
#include "devices/posix/serial_port.h"
#include "devices/posix/tcp_stream.h"
#include "sim/machines/external/virtual_program.h"
#include "sim/machines/grbl/grbl_host.h"
#include "tests/devices/modbus/modbus_support.h"
#include "tests/linuxcnc/fake_linuxcnc.h"

namespace palpate::machine_contract_test {
namespace {

const Point kStart = test::kStart;
constexpr double kRadius = test::kRadius;  // mm, of a sphere around the origin
constexpr double kResolution = 0.002;      // mm, of positions that are rounded both ways

// A controller that refuses a machine that is not homed.
class GrblRig {
public:
    explicit GrblRig(bool is_homed, std::optional<int> tcp_port = {})
        : grbl_(tool_, virtual_options(is_homed)), host_(grbl_, {{}, GrblHostOptions::Time::fast, false, tcp_port, false}) {}

    [[nodiscard]] std::unique_ptr<Machine> connect() {
        GrblOptions options;
        options.origin = test::kOrigin;
        std::unique_ptr<ByteStream> stream;
        if (const auto address = parse_tcp_address(host_.client_path())) {
            stream = std::make_unique<TcpStream>(*address);
        } else {
            stream = std::make_unique<SerialPort>(SerialPortOptions{host_.client_path()});
        }
        return std::make_unique<StreamGrblMachine>(std::move(stream), options);
    }
    void place(const Point& p) {
        host_.with([&](VirtualGrbl&) { tool_.place(p + test::kOrigin); });
    }
    [[nodiscard]] VirtualToolAudit audit() {
        VirtualToolAudit audit;
        host_.with([&](VirtualGrbl&) { audit = tool_.audit(); });
        return audit;
    }

private:
    static VirtualGrblOptions virtual_options(bool is_homed) {
        VirtualGrblOptions options;
        options.locked = !is_homed;
        return options;
    }

    HiddenObject object_{ShapeSpec{SphereSpec{kRadius}}};
    VirtualTool tool_{object_, test::machine_options().tool};
    VirtualGrbl grbl_;
    GrblHost host_;
};

class GrblTcpRig : public GrblRig {
public:
    explicit GrblTcpRig(bool is_homed) : GrblRig(is_homed, 0) {}
};

class ModbusRig {
public:
    explicit ModbusRig(bool is_homed) {
        if (!is_homed) machine_->with_controller([](VirtualModbusController& c) { c.reset(); });
    }
    [[nodiscard]] std::unique_ptr<Machine> connect() { return std::make_unique<ModbusMachine>(machine_.options()); }
    void place(const Point& p) {
        machine_->with_controller([&](VirtualModbusController& c) { c.tool().place(p + test::kOrigin); });
    }
    [[nodiscard]] VirtualToolAudit audit() { return machine_.audit(); }

private:
    test::Machine machine_{test::Wire::tcp};
};

class ExternalRig {
public:
    explicit ExternalRig(bool is_homed) : program_(tool_, virtual_options(is_homed)) {}
    [[nodiscard]] std::unique_ptr<Machine> connect() {
        ExternalOptions options;
        options.origin = test::kOrigin;
        return std::make_unique<ExternalMachine>(std::make_unique<TcpStream>(*parse_host_port(program_.address())), options);
    }
    void place(const Point& p) {
        program_.with([&](VirtualTool& tool) { tool.place(p + test::kOrigin); });
    }
    [[nodiscard]] VirtualToolAudit audit() {
        VirtualToolAudit audit;
        program_.with([&](VirtualTool& tool) { audit = tool.audit(); });
        return audit;
    }

private:
    static VirtualProgramOptions virtual_options(bool is_homed) {
        VirtualProgramOptions options;
        options.homed = is_homed;
        return options;
    }
    HiddenObject object_{ShapeSpec{SphereSpec{kRadius}}};
    VirtualTool tool_{object_, test::machine_options().tool};
    VirtualProgram program_;
};

class LinuxCncRig {
public:
    explicit LinuxCncRig(bool is_homed)
        : machine_(test::small_ball(kRadius, test::kOrigin, kStart + test::kOrigin, is_homed ? "" : "unhomed")) {}
    [[nodiscard]] std::unique_ptr<Machine> connect() {
        ExternalOptions options;
        options.origin = test::kOrigin;
        options.silence = Seconds(1);  // of a loaded computer
        return std::make_unique<ExternalMachine>(machine_.connect(), options);
    }
    void place(const Point& p) { machine_.place(p + test::kOrigin); }
    [[nodiscard]] VirtualToolAudit audit() {
        VirtualToolAudit audit;
        audit.moves = machine_.moves();
        audit.unguarded_moves = machine_.unguarded_moves();
        return audit;
    }

private:
    test::FakeLinuxCnc machine_;
};

template <class Rig>
class MachineContract : public ::testing::Test {};
using Rigs = ::testing::Types<GrblRig, GrblTcpRig, ModbusRig, ExternalRig, LinuxCncRig>;
TYPED_TEST_SUITE(MachineContract, Rigs);

TYPED_TEST(MachineContract, AMachineThatIsNotHomedSaysSoAndIsNotMoved) {
    TypeParam rig(false);
    const std::unique_ptr<Machine> machine = rig.connect();
    const MachineReport report = machine->report();
    EXPECT_TRUE(report.needs_homing);
    EXPECT_TRUE(report.has_problems());
    EXPECT_FALSE(machine->is_position_trusted());
    EXPECT_THROW(machine->make_ready(), DeviceError);
    EXPECT_EQ(rig.audit().moves, 0U);
}

TYPED_TEST(MachineContract, AMachineThatIsReadyTouchesInTheCoordinatesOfTheSession) {
    TypeParam rig(true);
    const std::unique_ptr<Machine> machine = rig.connect();
    const MachineReport report = machine->report();
    EXPECT_FALSE(report.needs_homing);
    EXPECT_FALSE(report.identity.empty());
    EXPECT_NEAR((report.position - kStart).norm(), 0, kResolution);
    EXPECT_TRUE(machine->is_position_trusted());
    EXPECT_FALSE(machine->is_probe_closed());
    machine->make_ready();
    EXPECT_EQ(rig.audit().moves, 0U);
    const MoveResult touch = machine->device().guarded_move(Point::Zero(), Pace::probe);
    EXPECT_EQ(touch.outcome, MoveResult::Outcome::contact);
    EXPECT_NEAR((touch.position - Point(kRadius, 0, 0)).norm(), 0, kResolution);
    EXPECT_FALSE(machine->is_probe_closed()) << "it went back";
}

TYPED_TEST(MachineContract, AToolThatWasLeftOnASurfaceIsTakenOffIt) {
    TypeParam rig(true);
    rig.place({kRadius - 0.1, 0, 0});
    const std::unique_ptr<Machine> machine = rig.connect();
    EXPECT_TRUE(machine->is_probe_closed());
    EXPECT_TRUE(machine->is_position_trusted());
    EXPECT_THROW(machine->make_ready(), ProbeClosed);
    EXPECT_EQ(rig.audit().moves, 0U);
    const Point off(kRadius + 1, 0, 0);
    machine->retreat(off);
    machine->make_ready();
    EXPECT_NEAR((machine->device().position() - off).norm(), 0, kResolution);
    EXPECT_FALSE(machine->is_probe_closed());
    EXPECT_EQ(rig.audit().unsafe_moves + rig.audit().unguarded_moves, 0U);
}

}  // namespace
}  // namespace palpate::machine_contract_test
