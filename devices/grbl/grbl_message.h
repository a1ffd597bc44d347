// What a GRBL-family controller says, line by line, as values. Pure: no port, no time (devices/FACTS.md, "GRBL").
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "planner/geometry.h"

namespace palpate::grbl {

struct Ok {};
struct Error {
    int code = 0;
};
struct Alarm {
    int code = 0;
};
// "Grbl 1.1h ['$' for help]", "GrblHAL 1.1f ['$' or '$HELP' for help]": the controller has started anew.
struct Banner {
    std::string version;  // "Grbl 1.1h"
};
// "[PRB:x,y,z:1]", in the units of reports ($13), machine coordinates. Without contact: where the move ended.
struct ProbeReport {
    Point position = Point::Zero();
    bool contact = false;
};
// "<Idle|MPos:…|…>".
struct Status {
    std::string state;             // "Idle", "Run", "Hold", "Alarm", "Home", "Jog", "Door", "Check", "Sleep", "Tool", "Critical" (FluidNC)
    std::optional<int> substate;   // "Hold:0"
    std::optional<Point> machine;  // MPos, in the units of reports
    std::optional<Point> work;     // WPos
    std::optional<Point> offset;   // WCO
    bool probe_closed = false;     // Pn:P
    bool probe_unplugged = false;  // Pn:O, grblHAL
    std::optional<bool> homed;     // H:0, H:1, grblHAL
    // Told in some reports only, and in the next one after a change.
    std::optional<int> feed_override;  // %, the first of Ov
    std::string running;               // of A: S or C spindle, F flood, M mist; empty where it says nothing of them
};
// "$110=500.000".
struct Setting {
    int number = 0;
    std::string value;
};
// "[MSG:Caution: Unlocked]", "[GC:G0 G54 …]", "[VER:…]", "[G54:0.000,0.000,0.000]".
struct Feedback {
    std::string kind;  // "MSG"
    std::string text;  // what follows the first colon
};
// Anything else, damaged lines among it.
struct Unknown {
    std::string text;
};

using Message = std::variant<Ok, Error, Alarm, Banner, ProbeReport, Status, Setting, Feedback, Unknown>;

// One line without its end. Strict: a number has the three decimals that the firmware prints in millimetres, or the four it prints
// in inches, so that a lost byte makes the line Unknown instead of another number. `decimals`: which of the two, once that is known.
// Throws nothing.
[[nodiscard]] Message parse(std::string_view line, std::optional<std::size_t> decimals = {});

// "1.000,-2.000,3.500"; nothing unless it is three such numbers.
[[nodiscard]] std::optional<Point> parse_coordinates(std::string_view text, std::optional<std::size_t> decimals = {});

// Bytes to lines; ends of lines are CR LF, CR or LF, and empty lines are dropped.
class LineBuffer {
public:
    void append(std::string_view bytes) { bytes_ += bytes; }
    // The next whole line. What is longer than any line of a controller comes in pieces.
    [[nodiscard]] std::optional<std::string> next();
    void clear() { bytes_.clear(); }

private:
    static constexpr std::size_t kLongest = 512;
    std::string bytes_;
};

// What an error or alarm code means, and what to do about it. Never empty.
[[nodiscard]] std::string explain_error(int code);
[[nodiscard]] std::string explain_alarm(int code);
// Whether nobody knows where the tool is after that alarm.
[[nodiscard]] bool loses_position(int alarm);
// Whether only a reset (Ctrl-X) leads out of that alarm.
[[nodiscard]] bool needs_reset(int alarm);

}  // namespace palpate::grbl
