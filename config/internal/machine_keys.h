// `machine:` of a configuration.
#pragma once

#include <fmt/format.h>

#include <array>
#include <string>
#include <string_view>
#include <variant>

#include "config/internal/box_keys.h"
#include "config/internal/kinds.h"
#include "config/machine_config.h"

namespace palpate::yaml {

inline constexpr std::string_view kFeedUnit = "mm/s";
inline constexpr std::array<std::string_view, 3> kHomingWords{"require", "run", "skip"};
inline constexpr std::array<std::string_view, 3> kProofWords{"auto", "hand", "first_touch"};
inline constexpr std::array<std::string_view, 3> kParityWords{"none", "even", "odd"};
inline constexpr std::string_view kParities = "NEO";
// mm/s: a controller of the GRBL family takes whole mm/min, and here 1 at least.
inline constexpr Bounds kFeedBounds{0.02};
// s: a controller that is asked how it is at such a distance is not watched.
inline constexpr Bounds kDelay{0.0, 5.0};
// s: several signs of life come within; longer, nobody watches.
inline constexpr Bounds kSilence{0.3, 5.0};
// s: below, not even a board that is on would be heard; above, nobody waits.
inline constexpr Bounds kBootTimes{1.0, 120.0};
// Less of a retract than that is lost in rounding.
inline constexpr double kLeastRetract = 5.0;  // resolutions
inline constexpr Whole kPorts{1, 65535};
inline constexpr Whole kUnits{1, 247};
inline constexpr Whole kBauds{1, 4'000'000};
inline constexpr std::uint64_t kMaxTouches = 100;
inline constexpr std::uint64_t kMostTouches = 1'000'000;  // of the part, from one datum to the next

template <class Archive>
void require_speed(Archive& keys, int baud) {
    keys.require(is_serial_speed(baud), "baud", fmt::format("{} is no speed of serial ports; allowed: {}", baud, serial_speeds()));
}

template <class Archive>
void describe(Archive& keys, GrblSpec& grbl) {
    keys.value(
        {"port", "serial port of the controller, such as /dev/ttyUSB0 (`palpate ports` lists them), or tcp://HOST:PORT", Need::required},
        grbl.port.path, Text{});
    keys.value({"baud", "its speed"}, grbl.port.baud, kBauds);
    keys.value(
        {"reset_on_open", "whether the board is reset when the port is opened, which frees its motors; false spares it where the port can"},
        grbl.port.reset, kFlag);
    keys.value({"boot_time",
                "what a board may need from the opening of its port to its first answer; one that is silent for half of it is sent a reset",
                Need::optional, kSeconds},
               grbl.boot_time, Number{kBootTimes});
    keys.value(
        {"delay", "what the network may take to carry a question and its answer; null: 0.5 s for tcp://HOST:PORT, 0 s for a serial port",
         Need::optional, kSeconds},
        grbl.delay, OrNull{Number{kDelay}});
    const auto address = grbl.address();
    keys.require(!is_tcp_address(grbl.port.path) || (address && address->port > 0), "port",
                 "is no address; allowed: tcp://HOST:PORT, such as tcp://192.168.1.20:23");
    require_speed(keys, grbl.port.baud);
}

template <class Archive>
void describe(Archive& keys, ModbusTcp& tcp) {
    keys.value({"host", "its name or address", Need::required}, tcp.host, Text{});
    keys.value({"port", "its port"}, tcp.port, kPorts);
}

template <class Archive>
void describe(Archive& keys, ModbusRtu& rtu) {
    std::size_t parity = kParities.find(rtu.parity);
    keys.value({"path", "serial port, such as /dev/ttyUSB0", Need::required}, rtu.path, Text{});
    keys.value({"baud", "its speed"}, rtu.baud, kBauds);
    keys.value({"parity", "its parity"}, parity, Word{kParityWords});
    keys.value({"stop_bits", "stop bits"}, rtu.stop_bits, Whole{1, 2});
    require_speed(keys, rtu.baud);
    rtu.parity = kParities.at(parity);
}

template <class Archive>
void describe(Archive& keys, ModbusSpec& modbus) {
    ModbusLinkOptions& link = modbus.link;
    alternative<ModbusTcp>(keys, {"tcp", "a controller on the network"}, link.where);
    alternative<ModbusRtu>(keys, {"rtu", "a controller on a serial line"}, link.where);
    keys.value({"unit", "the controller's unit id, 1 to 247"}, link.unit, kUnits);
    keys.value({"slowest_answer",
                "what an answer may take at most; one that is lost for so long while the axes move lets the controller stop by itself, and "
                "the move goes on afterwards",
                Need::optional, kSeconds},
               link.slowest_answer, Number{kPositive});
    link.answer_timeout = link.slowest_answer;  // each is waited for as long as one may take
    keys.value({"reconnect_time", "a controller or a network that is away is waited for so long", Need::optional, kSeconds},
               link.reconnect_time, Number{kNotNegative});
    keys.value({"busy_time", "exceptions 5, 6 and 0Bh (acknowledge, busy, gateway target failed) are tried again for so long",
                Need::optional, kSeconds},
               link.busy_time, Number{kNotNegative});
    keys.value({"profile", "file with the register map, relative to the config file; see devices/README.md", Need::optional, "", "ours"},
               modbus.profile, File{});
    keys.require_one_alternative();
}

template <class Archive>
void describe(Archive& keys, ExternalSpec& external) {
    keys.value({"command", "the program and its arguments, started in the folder that palpate is run in", Need::optional, "", "none"},
               external.command, Texts{});
    keys.value({"address", "HOST:PORT, where it listens already", Need::optional, "", "none"}, external.address, TextOrNone{});
    keys.value({"silence", "a program that is silent for so long in a move is told to stop, and taken for dead", Need::optional, kSeconds},
               external.silence, Number{kSilence});
    keys.value({"slowest_answer", "what an answer may take that waits for no motion", Need::optional, kSeconds}, external.slowest_answer,
               Number{kPositive});
    keys.value({"start_time", "what it may take from its start to its first answer", Need::optional, kSeconds}, external.start_time,
               Number{kPositive});
    keys.require(external.command.empty() != external.address.empty(), "command", "or `address` is needed, and not both");
    const auto address = parse_host_port(external.address);
    keys.require(external.address.empty() || (address && address->port > 0), "address", "is no address; allowed: HOST:PORT");
}

template <class Archive>
void describe(Archive& keys, Feeds& feeds) {
    keys.value({"travel", "between touches", Need::optional, kFeedUnit}, feeds.travel_mm_per_s, Number{kFeedBounds});
    keys.value({"probe", "towards a touch", Need::optional, kFeedUnit}, feeds.probe_mm_per_s, Number{kFeedBounds});
    keys.value({"touch", "where a touch is measured again", Need::optional, kFeedUnit}, feeds.touch_mm_per_s, Number{kFeedBounds});
}

template <class Archive>
void describe(Archive& keys, MultiTouchOptions& touch) {
    keys.value({"samples", "touches whose median counts; 1: the first, looked at again"}, touch.samples, Whole{1, kMaxTouches});
    keys.value({"tolerance", "they lie together that closely", Need::optional, kMillimetres}, touch.tolerance_mm, Number{kLength});
    keys.value({"retries", "further touches in place of those that do not agree"}, touch.retries, Whole{0, kMaxTouches});
    keys.value({"discard_first", "whether the first slow touch does not count: first touches are often off"}, touch.discard_first, kFlag);
    keys.value({"confirm", "whether a single touch is looked at again, so that a false trigger is found out"}, touch.confirm, kFlag);
    keys.value({"confirm_travel", "the same for a touch where space is known to be free"}, touch.confirm_travel, kFlag);
}

template <class Archive>
void describe(Archive& keys, DatumTouch& touch) {
    keys.value({"from", "where it begins: outside the workspace, and reached straight from its boundary", Need::required, kMillimetres},
               touch.from, Triple{Number{kCoordinate}});
    keys.value({"to", "where it ends at the latest: the datum is touched before, square to its face", Need::required, kMillimetres},
               touch.to, Triple{Number{kCoordinate}});
    keys.require(touch.from != touch.to, "to", "is where `from` is; allowed: another place (mm)");
}

template <class Archive>
void describe(Archive& keys, DriftDatum& datum) {
    keys.value({"every", "touches of the part from one visit to the next"}, datum.every, Whole{1, kMostTouches});
    list(keys, {"at", "touches of it: three with independent directions show the whole shift, fewer what is along theirs", Need::required},
         {.least = 1}, datum.touches);
    keys.value({"limit", "what changes more from one visit to the next is no drift: the session stops", Need::optional, kMillimetres},
               datum.limit_mm, Number{kLength});
}

// How it moves, and when it touches.
template <class Archive>
void describe_motion(Archive& keys, MotionModel& motion) {
    mapping(keys, {"feeds", "how fast it moves", Need::optional, "", "the defaults below"}, motion.feeds);
    keys.value({"acceleration", "of the slowest axis", Need::optional, "mm/s²"}, motion.acceleration_mm_per_s2, Number{kPositive});
    keys.value({"latency", "from the trigger until the machine slows down", Need::optional, kSeconds}, motion.latency,
               Number{kNotNegative});
    keys.value({"overtravel", "what the probe gives way after its trigger; every feed must stop within it", Need::optional, kMillimetres},
               motion.overtravel_mm, Number{kLength});
    keys.value(
        {"retract", "back after a touch, on the way that the tool came; more than the probe's hysteresis", Need::optional, kMillimetres},
        motion.retract_mm, Number{kLength});
    keys.value({"resolution", "last digit of the machine's positions", Need::optional, kMillimetres}, motion.resolution_mm,
               Number{kLength});
}

template <class Archive>
void describe(Archive& keys, MachineConfig& machine) {
    alternative<GrblSpec>(keys, {"grbl", "a controller of the GRBL family on a serial port or on the network"}, machine.connection);
    alternative<ModbusSpec>(keys, {"modbus", "a controller that speaks Modbus"}, machine.connection);
    alternative<ExternalSpec>(keys, {"external", "a program of your own that drives the machine; devices/external/PROTOCOL.md"},
                              machine.connection);
    keys.value({"homing",
                "a machine that is locked or not homed is refused, is homed, or (no switches, machine.grbl alone) is taken to be where it "
                "says; with machine.modbus: require"},
               machine.homing, Word{kHomingWords});
    keys.value({"origin", "machine coordinates of this configuration's origin", Need::optional, kMillimetres}, machine.origin,
               Triple{Number{kCoordinate}});
    keys.mapping({"limits", "box that the tool never leaves, in this configuration's coordinates", Need::required}, true,
                 [&](Archive& inner) { describe_box(inner, "lowest corner", "highest corner", machine.limits); });
    describe_motion(keys, machine.motion);
    keys.value({"noise", "touches may be off by that besides: repeatability and lobing of the probe", Need::optional, kMillimetres},
               machine.noise_mm, Number{kLengthOrZero});
    mapping(keys, {"touch", "how a touch is measured", Need::optional, "", "the defaults below"}, machine.touch);
    keys.value({"datum_tolerance",
                "known places that a resumed session touches again may be off by that; null: twice what touches may be wrong by, 2 x "
                "resolution + noise",
                Need::optional, kMillimetres},
               machine.datum_tolerance_mm, OrNull{Number{kLength}});
    keys.value({"probe_proof",
                "what shows that the probe works before a session relies on it: it is pressed by hand, or the first touch, until which all "
                "motion is as slow as a probe; auto: by hand at a terminal, the first touch with --yes"},
               machine.probe_proof, Word{kProofWords});
    if (keys.wants(machine.datum.has_value())) {
        mapping(keys,
                {"datum", "what stands still beside the part, and is touched now and then to see drift and take it out; devices/README.md",
                 Need::optional, "", "none", Layout::block},
                machine.datum);
    }
    keys.require_one_alternative();
    const bool is_grbl = std::holds_alternative<GrblSpec>(machine.connection);
    keys.require(machine.homing != Homing::skip || is_grbl, "homing",
                 "says that what is locked is unlocked, which only machine.grbl can be; allowed: require");
    keys.require(machine.homing != Homing::run || is_grbl || std::holds_alternative<ExternalSpec>(machine.connection), "homing",
                 "has no command with machine.modbus; allowed: require; home the machine by its own means");
    const std::string problem = stopping_problem(machine.motion);
    keys.require(problem.empty(), "overtravel", fmt::format("is too small: {}; allowed: more than that, or lower machine.feeds", problem));
    keys.require(machine.motion.retract_mm >= kLeastRetract * machine.motion.resolution_mm, "retract",
                 "is lost in the machine's rounding; allowed: at least 5 x machine.resolution");
}

}  // namespace palpate::yaml
