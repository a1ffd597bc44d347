#include "config/internal/read_machine.h"

#include <array>

namespace palpate::yaml {
namespace {

constexpr std::string_view kMillimetres = "mm";
constexpr std::string_view kFeedUnit = "mm/s";
constexpr std::array<std::string_view, 3> kHomingWords{"require", "run", "skip"};
constexpr std::array<std::string_view, 3> kProofWords{"auto", "hand", "first_touch"};
constexpr std::array<std::string_view, 3> kParityWords{"none", "even", "odd"};
constexpr std::array<char, 3> kParities{'N', 'E', 'O'};
// mm/s: a controller of the GRBL family takes whole mm/min, and here 1 at least.
constexpr Bounds kFeedBounds{0.02};
// Less of a retract than that is lost in rounding.
constexpr double kLeastRetract = 5.0;  // resolutions
constexpr int kMaxPort = 65535;
constexpr int kMaxUnit = 247;
constexpr int kMaxBaud = 4'000'000;
constexpr int kMaxTouches = 100;

void require_speed(Section& section, int baud) {
    section.require(is_serial_speed(baud), "baud", std::to_string(baud) + " is no speed of serial ports; allowed: " + serial_speeds());
}

GrblSpec read_grbl(Section& section) {
    GrblSpec grbl;
    grbl.port.path =
        section.text({"port", "serial port of the controller, such as /dev/ttyUSB0; `palpate ports` lists them", Need::required});
    grbl.port.baud = section.whole_number({"baud", "its speed"}, 1, kMaxBaud, grbl.port.baud);
    grbl.port.reset = section.flag(
        {"reset_on_open", "whether the board is reset when the port is opened, which frees its motors; false spares it where the port can"},
        grbl.port.reset);
    require_speed(section, grbl.port.baud);
    return grbl;
}

ModbusSpec read_modbus(Section& section, const std::filesystem::path& folder) {
    ModbusSpec modbus;
    section.mapping({"tcp", "a controller on the network", Need::alternative}, [&](Section& inner) {
        ModbusTcp tcp;
        tcp.host = inner.text({"host", "its name or address", Need::required});
        tcp.port = inner.whole_number({"port", "its port"}, 1, kMaxPort, tcp.port);
        modbus.link.where = tcp;
    });
    section.mapping({"rtu", "a controller on a serial line", Need::alternative}, [&](Section& inner) {
        ModbusRtu rtu;
        rtu.path = inner.text({"path", "serial port, such as /dev/ttyUSB0", Need::required});
        rtu.baud = inner.whole_number({"baud", "its speed"}, 1, kMaxBaud, rtu.baud);
        rtu.parity = kParities.at(inner.word({"parity", "its parity"}, kParityWords, 1));
        rtu.stop_bits = inner.whole_number({"stop_bits", "stop bits"}, 1, 2, rtu.stop_bits);
        require_speed(inner, rtu.baud);
        modbus.link.where = rtu;
    });
    modbus.link.unit = section.whole_number({"unit", "the controller's unit id, 1 to 247"}, 1, kMaxUnit, modbus.link.unit);
    modbus.link.slowest_answer = Seconds(section.number({"slowest_answer",
                                                         "what an answer may take at most; one that is lost for so long while the axes "
                                                         "move lets the controller stop by itself, and the move goes on afterwards",
                                                         Need::optional, "s"},
                                                        kPositive, modbus.link.slowest_answer.count()));
    modbus.link.answer_timeout = modbus.link.slowest_answer;  // each is waited for as long as one may take
    modbus.link.reconnect_time =
        Seconds(section.number({"reconnect_time", "a controller or a network that is away is waited for so long", Need::optional, "s"},
                               kNotNegative, modbus.link.reconnect_time.count()));
    modbus.link.busy_time = Seconds(
        section.number({"busy_time", "exceptions 5, 6 and 0Bh (acknowledge, busy, gateway target failed) are tried again for so long",
                        Need::optional, "s"},
                       kNotNegative, modbus.link.busy_time.count()));
    const std::string profile = section.text(
        {"profile", "file with the register map, relative to the config file; see devices/README.md", Need::optional, "", "ours"});
    if (!profile.empty()) modbus.profile = (folder / profile).lexically_normal();
    section.require_one_alternative();
    return modbus;
}

Feeds read_feeds(Section& section) {
    Feeds feeds;
    feeds.travel_mm_per_s = section.number({"travel", "between touches", Need::optional, kFeedUnit}, kFeedBounds, feeds.travel_mm_per_s);
    feeds.probe_mm_per_s = section.number({"probe", "towards a touch", Need::optional, kFeedUnit}, kFeedBounds, feeds.probe_mm_per_s);
    feeds.touch_mm_per_s =
        section.number({"touch", "where a touch is measured again", Need::optional, kFeedUnit}, kFeedBounds, feeds.touch_mm_per_s);
    return feeds;
}

MultiTouchOptions read_touch(Section& section) {
    MultiTouchOptions touch;
    touch.samples =
        section.whole_number({"samples", "touches whose median counts; 1: the first, looked at again"}, 1, kMaxTouches, touch.samples);
    touch.tolerance_mm =
        section.number({"tolerance", "they lie together that closely", Need::optional, kMillimetres}, kPositive, touch.tolerance_mm);
    touch.retries = section.whole_number({"retries", "further touches in place of those that do not agree"}, 0, kMaxTouches, touch.retries);
    touch.discard_first =
        section.flag({"discard_first", "whether the first slow touch does not count: first touches are often off"}, touch.discard_first);
    touch.confirm =
        section.flag({"confirm", "whether a single touch is looked at again, so that a false trigger is found out"}, touch.confirm);
    touch.confirm_travel = section.flag({"confirm_travel", "the same for a touch where space is known to be free"}, touch.confirm_travel);
    return touch;
}

Box read_limits(Section& section) {
    Box box;
    box.min = section.vector({"min", "lowest corner", Need::required, kMillimetres}, kAnyNumber);
    box.max = section.vector({"max", "highest corner", Need::required, kMillimetres}, kAnyNumber);
    section.require(box.is_valid(), "max", "is not greater than min in each coordinate; allowed: greater than min in x, y and z (mm)");
    return box;
}

}  // namespace

MachineConfig read_machine(Section& section, const std::filesystem::path& folder) {
    MachineConfig machine;
    section.mapping({"grbl", "a controller of the GRBL family on a serial port", Need::alternative},
                    [&](Section& inner) { machine.connection = read_grbl(inner); });
    section.mapping({"modbus", "a controller that speaks Modbus", Need::alternative},
                    [&](Section& inner) { machine.connection = read_modbus(inner, folder); });
    machine.homing = static_cast<Homing>(
        section.word({"homing",
                      "a machine that is locked or not homed is refused, is homed, or (no switches) is taken to be where it says; with "
                      "machine.modbus: require"},
                     kHomingWords, static_cast<std::size_t>(machine.homing)));
    machine.origin = section.vector({"origin", "machine coordinates of this configuration's origin", Need::optional, kMillimetres},
                                    kAnyNumber, machine.origin);
    section.mapping({"limits", "box that the tool never leaves, in this configuration's coordinates", Need::required},
                    [&](Section& inner) { machine.limits = read_limits(inner); });
    Kinematics& k = machine.kinematics;
    section.mapping({"feeds", "how fast it moves", Need::optional, "", "the defaults below"},
                    [&](Section& inner) { k.feeds = read_feeds(inner); });
    k.acceleration_mm_per_s2 =
        section.number({"acceleration", "of the slowest axis", Need::optional, "mm/s²"}, kPositive, k.acceleration_mm_per_s2);
    k.latency = Seconds(
        section.number({"latency", "from the trigger until the machine slows down", Need::optional, "s"}, kNotNegative, k.latency.count()));
    k.overtravel_mm = section.number(
        {"overtravel", "what the probe gives way after its trigger; every feed must stop within it", Need::optional, kMillimetres},
        kPositive, k.overtravel_mm);
    k.retract_mm = section.number(
        {"retract", "back after a touch, on the way that the tool came; more than the probe's hysteresis", Need::optional, kMillimetres},
        kPositive, k.retract_mm);
    k.resolution_mm =
        section.number({"resolution", "last digit of the machine's positions", Need::optional, kMillimetres}, kPositive, k.resolution_mm);
    machine.noise_mm =
        section.number({"noise", "touches may be off by that besides: repeatability and lobing of the probe", Need::optional, kMillimetres},
                       kNotNegative, machine.noise_mm);
    section.mapping({"touch", "how a touch is measured", Need::optional, "", "the defaults below"},
                    [&](Section& inner) { machine.touch = read_touch(inner); });
    machine.datum_tolerance_mm = section.number_or_null(
        {"datum_tolerance",
         "known places that a resumed session touches again may be off by that; null: twice what touches may be wrong by, 2 x resolution "
         "+ noise",
         Need::optional, kMillimetres},
        kPositive);
    machine.probe_proof =
        static_cast<ProbeProof>(section.word({"probe_proof",
                                              "what shows that the probe works before a session relies on it: it is pressed by hand, or "
                                              "the first touch, until which all motion is "
                                              "as slow as a probe; auto: by hand at a terminal, the first touch with --yes"},
                                             kProofWords, static_cast<std::size_t>(machine.probe_proof)));
    section.require_one_alternative();
    section.require(machine.homing == Homing::require || std::holds_alternative<GrblSpec>(machine.connection), "homing",
                    "is not possible with machine.modbus, whose registers have no command for it; allowed: require; home the machine at "
                    "its own panel");
    const std::string problem = stopping_problem(k);
    section.require(problem.empty(), "overtravel", "is too small: " + problem + "; allowed: more than that, or lower machine.feeds");
    section.require(k.retract_mm >= kLeastRetract * k.resolution_mm, "retract",
                    "is lost in the machine's rounding; allowed: at least 5 x machine.resolution");
    return machine;
}

}  // namespace palpate::yaml
