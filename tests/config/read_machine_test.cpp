#include <gtest/gtest.h>

#include "config/reader.h"
#include "tests/config/support.h"

namespace palpate::read_machine_test {
namespace {

const std::string kRest = "limits: {min: [-20, -20, -20], max: [20, 20, 40]}}\nprobing: {epsilon: 0.25}\n";
const std::string kGrbl = "machine: {grbl: {port: /dev/ttyUSB0}, ";
const std::string kModbus = "machine: {modbus: {tcp: {host: mill}}, ";

class MachineReader : public testing::Test {
protected:
    [[nodiscard]] SessionConfig read(const std::string& text) const { return read_config(folder_.write("s.yaml", text), {}); }

    // What the reader says about `text`, without folder and line.
    [[nodiscard]] std::string complaint(const std::string& text) const {
        try {
            (void)read(text);
        } catch (const ConfigError& error) {
            const std::string message = error.what();
            const std::size_t line = message.find("s.yaml:");
            return message.substr(message.find(' ', line) + 1);
        }
        return "nothing";
    }

    test::TemporaryFolder folder_;
};

TEST_F(MachineReader, FillsInDefaults) {
    const MachineConfig machine = read(kGrbl + kRest).machine.value();
    const auto& grbl = std::get<GrblSpec>(machine.connection);
    EXPECT_EQ(grbl.port.path, "/dev/ttyUSB0");
    EXPECT_EQ(grbl.port.baud, 115200);
    EXPECT_EQ(machine.homing, Homing::require);
    EXPECT_EQ(machine.origin, Point::Zero());
    EXPECT_EQ(machine.limits.max, Point(20, 20, 40));
    EXPECT_TRUE(machine.touch.confirm);
    EXPECT_TRUE(machine.touch.confirm_travel);
    const auto modbus = std::get<ModbusSpec>(read(kModbus + kRest).machine->connection);
    EXPECT_EQ(std::get<ModbusTcp>(modbus.link.where).port, 502);
    EXPECT_EQ(modbus.link.unit, 1);
    const auto slow = std::get<ModbusSpec>(read("machine: {modbus: {tcp: {host: mill}, slowest_answer: 3}, " + kRest).machine->connection);
    EXPECT_EQ(slow.link.answer_timeout, Seconds(3)) << "an answer is waited for as long as one may take";
    EXPECT_EQ(slow.link.reconnect_time, Seconds(10));
    const auto patient =
        std::get<ModbusSpec>(read("machine: {modbus: {tcp: {host: mill}, reconnect_time: 60, busy_time: 2}, " + kRest).machine->connection);
    EXPECT_EQ(patient.link.reconnect_time, Seconds(60));
    EXPECT_EQ(patient.link.busy_time, Seconds(2));
}

TEST_F(MachineReader, MachinesOnANetworkAndProgramsAreNamed) {
    const auto grbl = [&](const std::string& keys) {
        return std::get<GrblSpec>(read("machine: {grbl: {" + keys + "}, " + kRest).machine->connection);
    };
    EXPECT_EQ(grbl("port: 'tcp://mill:23'").address(), (TcpAddress{"mill", 23}));
    EXPECT_EQ(grbl("port: 'tcp://mill:23'").delay, std::nullopt);
    EXPECT_EQ(grbl("port: 'tcp://mill:23', delay: 0.2, boot_time: 20").delay, Seconds(0.2));
    EXPECT_EQ(grbl("port: /dev/ttyUSB0").address(), std::nullopt);
    for (const std::string port : {"tcp://mill", "tcp://mill:0", "tcp://:23", "tcp://mill:70000"}) {
        EXPECT_EQ(complaint("machine: {grbl: {port: '" + port + "'}, " + kRest),
                  "machine.grbl.port: is no address; allowed: tcp://HOST:PORT, such as tcp://192.168.1.20:23");
    }
    const auto external = [&](const std::string& keys) { return "machine: {external: {" + keys + "}, " + kRest; };
    EXPECT_EQ(std::get<ExternalSpec>(read(external("command: [python3, arm.py]")).machine->connection).command,
              (std::vector<std::string>{"python3", "arm.py"}));
    EXPECT_EQ(std::get<ExternalSpec>(read(external("address: 'robot:4000'")).machine->connection).address, "robot:4000");
    EXPECT_EQ(complaint(external("silence: 1")), "machine.external.command: or `address` is needed, and not both");
    EXPECT_EQ(complaint(external("command: [a], address: 'b:1'")), "machine.external.command: or `address` is needed, and not both");
    EXPECT_EQ(complaint(external("address: robot")), "machine.external.address: is no address; allowed: HOST:PORT");
    EXPECT_THAT(complaint(external("command: python3 arm.py")), ::testing::HasSubstr("is not a list of texts"));
    EXPECT_THAT(complaint(external("command: []")), ::testing::HasSubstr("is not a list of texts"));
    EXPECT_THAT(complaint(external("command: [a, '']")), ::testing::HasSubstr("is empty or holds a zero byte"));
}

// What the planner has to know of the machine goes with the task.
TEST_F(MachineReader, TellsThePlannerWhatTheMachineCan) {
    const SessionConfig config = read(
        kGrbl + "resolution: 0.01, noise: 0.003, retract: 0.7, acceleration: 100, latency: 0.01, feeds: {travel: 15, probe: 4}, " + kRest);
    EXPECT_DOUBLE_EQ(config.traits().touch_error, 0.023);
    EXPECT_EQ(config.traits().retract, 0.7);
    EXPECT_EQ(config.traits().rates.travel_feed_mm_per_s, 15);
    EXPECT_EQ(config.traits().rates.probe_feed_mm_per_s, 4);
    // It runs on by 4 · 0.01 + 16/200 = 0.12 mm, and speeding up and slowing down take 0.04 s on each way.
    EXPECT_NEAR(config.traits().rates.touch.count(), 0.12 / 4 + 0.04 + 0.82 / 4 + 0.04, 1e-12);
}

TEST_F(MachineReader, RefusesWhatCannotBe) {
    EXPECT_EQ(complaint("machine: {" + kRest), "machine: holds none of its alternatives; allowed: exactly one of grbl, modbus, external");
    EXPECT_EQ(complaint("machine: {grbl: {port: /dev/ttyUSB0}}\nprobing: {epsilon: 1}\n"),
              "machine.limits: is required; allowed: a mapping of the keys below it");
    EXPECT_EQ(complaint(kGrbl + "limits: {min: [0, 0, 0], max: [1, 0, 1]}}\nprobing: {epsilon: 1}\n"),
              "machine.limits.max: is not greater than min in each coordinate; allowed: greater than min in x, y and z (mm)");
    // 60 · 0.002 + 3600/400
    EXPECT_EQ(
        complaint(kGrbl + "feeds: {travel: 60}, " + kRest),
        "machine.overtravel: is too small: at 60 mm/s the machine needs 9.12 mm to stop, but the probe gives way by 2 mm; allowed: more "
        "than that, or lower machine.feeds");
    EXPECT_EQ(complaint("machine: {grbl: {port: x, baud: 250001}, " + kRest),
              "machine.grbl.baud: 250001 is no speed of serial ports; allowed: " + serial_speeds());
    EXPECT_EQ(complaint("machine: {modbus: {rtu: {path: x, baud: 250000}}, " + kRest),
              "machine.modbus.rtu.baud: 250000 is no speed of serial ports; allowed: " + serial_speeds());
    EXPECT_EQ(complaint(kGrbl + "retract: 0.004, " + kRest),
              "machine.retract: is lost in the machine's rounding; allowed: at least 5 x machine.resolution");
    const std::string external = "machine: {external: {address: \"127.0.0.1:5010\"}, ";
    EXPECT_EQ(complaint(kModbus + "homing: run, " + kRest),
              "machine.homing: has no command with machine.modbus; allowed: require; home the machine by its own means");
    for (const std::string& machine : {kModbus, external}) {
        EXPECT_EQ(complaint(machine + "homing: skip, " + kRest),
                  "machine.homing: says that what is locked is unlocked, which only machine.grbl can be; allowed: require");
        EXPECT_EQ(complaint(machine + "homing: require, " + kRest), "nothing");
    }
    EXPECT_EQ(complaint(external + "homing: run, " + kRest), "nothing");
}

TEST_F(MachineReader, ADatumIsTouchedInOnePlaceAtLeast) {
    EXPECT_FALSE(read(kGrbl + kRest).machine->datum);
    const DriftDatum datum =
        read(kGrbl + "datum: {at: [{from: [9, 0, 0], to: [11, 0, 0]}, {from: [9, 5, 0], to: [9, 4, 0]}]}, " + kRest).machine->datum.value();
    EXPECT_EQ(datum.every, 100U);
    EXPECT_EQ(datum.limit_mm, 0.1);
    ASSERT_EQ(datum.touches.size(), 2U);
    EXPECT_EQ(datum.touches[1].from, Point(9, 5, 0));
    EXPECT_EQ(datum.touches[1].inwards(), Vector(0, -1, 0));
    const auto complaint_of = [&](const std::string& text) { return complaint(kGrbl + "datum: {" + text + "}, " + kRest); };
    const std::string at = "at: [{from: [9, 0, 0], to: [11, 0, 0]}]";
    EXPECT_EQ(complaint_of("every: 5"), "machine.datum.at: is required; allowed: at least 1");
    EXPECT_EQ(complaint_of("every: 0, " + at), "machine.datum.every: 0 is out of range; allowed: from 1 to 1000000");
    EXPECT_EQ(complaint_of("limit: 0, " + at), "machine.datum.limit: 0 is out of range; allowed: greater than 0, at most 1000000 (mm)");
    EXPECT_EQ(complaint_of("at: [{from: [9, 0, 0], to: [9, 0, 0]}]"),
              "machine.datum.at[0].to: is where `from` is; allowed: another place (mm)");
    EXPECT_EQ(complaint_of("at: [{from: [9, 0, 0], towards: [9, 0, 0]}]").substr(0, 26), "machine.datum.at[0].toward");
}

}  // namespace
}  // namespace palpate::read_machine_test
