#include "devices/grbl/grbl_message.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <vector>

namespace palpate::grbl {
namespace {

std::vector<std::string_view> split(std::string_view text, char separator) {
    std::vector<std::string_view> parts;
    while (true) {
        const std::size_t end = text.find(separator);
        parts.push_back(text.substr(0, end));
        if (end == std::string_view::npos) return parts;
        text.remove_prefix(end + 1);
    }
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// [-]digits.ddd or [-]digits.dddd
std::optional<double> parse_coordinate(std::string_view text, std::optional<std::size_t> expected_decimals) {
    const std::string_view digits = text.substr(!text.empty() && text.front() == '-' ? 1 : 0);
    const std::size_t point = digits.find('.');
    if (point == std::string_view::npos || point == 0) return std::nullopt;
    const std::size_t decimals = digits.size() - point - 1;
    if (expected_decimals ? decimals != *expected_decimals : decimals != 3 && decimals != 4) return std::nullopt;
    for (std::size_t k = 0; k < digits.size(); ++k) {
        if (k != point && !is_digit(digits[k])) return std::nullopt;
    }
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

std::optional<int> parse_int(std::string_view text) {
    int value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || value < 0) return std::nullopt;
    return value;
}

Message parse_probe(std::string_view body, std::string_view line, std::optional<std::size_t> decimals) {
    const std::size_t colon = body.rfind(':');
    const auto position = parse_coordinates(body.substr(0, colon), decimals);
    const std::string_view flag = colon == std::string_view::npos ? std::string_view() : body.substr(colon + 1);
    if (!position || (flag != "0" && flag != "1")) return Unknown{std::string(line)};
    return ProbeReport{*position, flag == "1"};
}

// "100,100,100": feed, rapids, spindle. A comma that got lost leaves fewer and longer numbers.
std::optional<int> parse_feed_override(std::string_view text) {
    constexpr int kLeast = 1;
    constexpr int kMost = 999;
    const auto parts = split(text, ',');
    if (parts.size() != 3) return std::nullopt;
    for (const std::string_view part : parts) {
        const auto value = parse_int(part);
        if (!value || *value < kLeast || *value > kMost) return std::nullopt;
    }
    return parse_int(parts[0]);
}

// What runs besides the axes; other letters say other things (a tool change, an encoder).
std::string running_of(std::string_view accessories) {
    std::string running;
    for (const char c : accessories) {
        if (std::string_view("SCFM").find(c) != std::string_view::npos) running += c;
    }
    return running;
}

Message parse_status(std::string_view line, std::optional<std::size_t> decimals) {
    const Unknown damaged{std::string(line)};
    const auto fields = split(line.substr(1, line.size() - 2), '|');
    static constexpr std::array<std::string_view, 11> kStates = {"Idle",  "Run",   "Hold", "Alarm", "Home",    "Jog",
                                                                 "Check", "Sleep", "Door", "Tool",  "Critical"};
    Status status;
    const auto state = split(fields[0], ':');
    if (std::find(kStates.begin(), kStates.end(), state[0]) == kStates.end()) return damaged;
    status.state = state[0];
    if (state.size() > 1) {
        status.substate = parse_int(state[1]);
        if (!status.substate) return damaged;
    }
    for (std::size_t k = 1; k < fields.size(); ++k) {
        const std::size_t colon = fields[k].find(':');
        const std::string_view key = fields[k].substr(0, colon);
        const std::string_view value = colon == std::string_view::npos ? std::string_view() : fields[k].substr(colon + 1);
        const auto place = [&](std::optional<Point>& into) {
            into = parse_coordinates(value, decimals);
            return into.has_value();
        };
        bool good = true;
        if (key == "MPos") good = place(status.machine);
        if (key == "WPos") good = place(status.work);
        if (key == "WCO") good = place(status.offset);
        if (key == "Pn") {
            status.probe_closed = value.find('P') != std::string_view::npos;
            status.probe_unplugged = value.find('O') != std::string_view::npos;
        }
        if (key == "Ov") {
            status.feed_override = parse_feed_override(value);
            good = status.feed_override.has_value();
        }
        if (key == "A") status.running = running_of(value);
        if (key == "H") status.homed = value.substr(0, 1) == "1";
        if (!good) return damaged;
    }
    if (!status.machine && !status.work) return damaged;
    return status;
}

struct Meaning {
    int code;
    const char* text;
};

template <std::size_t N>
std::string meaning(const std::array<Meaning, N>& meanings, int code, const char* otherwise) {
    for (const Meaning& m : meanings) {
        if (m.code == code) return m.text;
    }
    return otherwise;
}

}  // namespace

std::optional<Point> parse_coordinates(std::string_view text, std::optional<std::size_t> decimals) {
    const auto parts = split(text, ',');
    if (parts.size() < 3) return std::nullopt;  // machines with more axes report more
    Point p;
    for (std::size_t axis = 0; axis < parts.size(); ++axis) {
        const auto value = parse_coordinate(parts[axis], decimals);
        if (!value) return std::nullopt;
        if (axis < 3) p[static_cast<Eigen::Index>(axis)] = *value;
    }
    return p;
}

Message parse(std::string_view line, std::optional<std::size_t> decimals) {
    // Bridges, of Bluetooth above all, pad lines and write them in capitals.
    while (!line.empty() && (line.back() == ' ' || line.back() == '\t')) line.remove_suffix(1);
    const Unknown unknown{std::string(line)};
    if (line == "ok" || line == "OK") return Ok{};
    if (line.starts_with("error:") || line.starts_with("ALARM:")) {
        const auto code = parse_int(line.substr(6));
        if (!code) return unknown;
        if (line.front() == 'e') return Error{*code};
        return Alarm{*code};
    }
    if ((line.starts_with("Grbl ") || line.starts_with("GrblHAL ")) && line.find('[') != std::string_view::npos) {
        std::string_view version = line.substr(0, line.find('['));
        while (!version.empty() && version.back() == ' ') version.remove_suffix(1);
        return Banner{std::string(version)};
    }
    if (line.size() >= 2 && line.front() == '<' && line.back() == '>') return parse_status(line, decimals);
    if (line.size() >= 2 && line.front() == '[' && line.back() == ']') {
        const std::string_view body = line.substr(1, line.size() - 2);
        const std::size_t colon = body.find(':');
        if (colon == std::string_view::npos) return unknown;
        if (body.substr(0, colon) == "PRB") return parse_probe(body.substr(colon + 1), line, decimals);
        return Feedback{std::string(body.substr(0, colon)), std::string(body.substr(colon + 1))};
    }
    if (line.size() >= 2 && line.front() == '$' && is_digit(line[1])) {
        const std::size_t equals = line.find('=');
        const auto number = equals == std::string_view::npos ? std::nullopt : parse_int(line.substr(1, equals - 1));
        if (!number) return unknown;
        // Some builds explain: "$0=10 (step pulse, usec)".
        std::string_view value = line.substr(equals + 1);
        value = value.substr(0, value.find(' '));
        return Setting{*number, std::string(value)};
    }
    return unknown;
}

std::optional<std::string> LineBuffer::next() {
    while (true) {
        const std::size_t end = bytes_.find_first_of("\r\n");
        if (end == std::string::npos && bytes_.size() < kLongest) return std::nullopt;
        std::string line = bytes_.substr(0, std::min(end, kLongest));
        bytes_.erase(0, std::min(end == std::string::npos ? kLongest : end + 1, bytes_.size()));
        if (!line.empty()) return line;
    }
}

std::string explain_error(int code) {
    static constexpr std::array<Meaning, 13> kMeanings = {{
        {1,
         "a command without a letter: bytes were lost on the line, or another program wrote to it, as ModemManager does to a port that is "
         "new "
         "(a udev rule with ENV{ID_MM_DEVICE_IGNORE}=\"1\" ends that); check the cable"},
        {2,
         "a number that cannot be read: bytes were lost on the line, or another program wrote to it, as ModemManager does to a port that "
         "is new "
         "(a udev rule with ENV{ID_MM_DEVICE_IGNORE}=\"1\" ends that); check the cable"},
        {8, "not idle: something else moves the machine; stop it"},
        {9, "locked: home the machine, or unlock it with $X if its position is right"},
        {11, "a line too long: bytes were lost on the line; check the cable"},
        {15, "a jog beyond the machine's travel"},
        {20, "a command that this firmware does not know: it was built without probing"},
        {22, "no feed rate"},
        {24, "two commands in one line that exclude each other: bytes were lost on the line; check the cable"},
        {26, "a motion without axes: bytes were lost on the line; check the cable"},
        {33, "a motion to where the tool is already"},
        {5, "homing is switched off ($22=0): switch it on, or say homing: skip"},
        {79, "still in alarm: reset it first"},
    }};
    return meaning(kMeanings, code, "see the firmware's list of error codes");
}

std::string explain_alarm(int code) {
    static constexpr std::array<Meaning, 12> kMeanings = {{
        {0, "locked, as after a start or an alarm"},
        {1, "a limit switch was hit and the position is lost: free the axis and home the machine"},
        {2, "a motion beyond the machine's travel was refused: compare machine.limits with $130 to $132"},
        {3, "reset while it moved, and the position is lost: home the machine"},
        {4, "the probe was closed, or unplugged, when a probing move began: free it and check its lead"},
        {5, "a probing move ended without contact"},
        {6, "homing was reset: home again"},
        {7, "a door opened during homing: close it and home again"},
        {8, "the limit switch stayed closed when homing pulled off: check it and home again"},
        {9, "homing found no limit switch: check it and home again"},
        {10, "homing found no second limit switch: check it and home again"},
        {11, "homing is required: home the machine"},
    }};
    return meaning(kMeanings, code, "see the firmware's list of alarm codes");
}

bool loses_position(int alarm) { return alarm != 2 && alarm != 4 && alarm != 5; }

bool needs_reset(int alarm) { return alarm == 1 || alarm == 2; }

}  // namespace palpate::grbl
