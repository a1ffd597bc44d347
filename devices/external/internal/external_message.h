// What a program that drives a machine says, line by line, as a value (devices/external/PROTOCOL.md). Pure: no stream, no time.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "planner/region.h"

namespace palpate::external {

// All that a line may hold; what each answer has to hold is for who asked.
struct Line {
    std::optional<std::uint64_t> id;  // nothing: a sign of life
    std::optional<std::string> error;
    std::optional<Point> position;  // mm, machine coordinates
    std::optional<Point> touched;
    std::optional<bool> probe_closed;
    std::optional<std::string> ended;
    std::optional<bool> moving;
    std::optional<bool> homed;
    std::optional<std::string> fault;
    std::optional<std::string> name;
    std::optional<Box> limits;
    std::optional<double> feed;          // mm/s
    std::optional<double> acceleration;  // mm/s²
    std::optional<double> resolution;    // mm
    std::optional<bool> stops_at_touch;
    std::optional<bool> latches;
    std::optional<double> latch_time;  // s
    std::optional<bool> homes;
    std::optional<std::string> why;  // a move was stopped
};

// What is wrong with a line, in words.
struct Malformed {
    std::string why;
};

// The longest line that is read, in bytes.
inline constexpr std::size_t kLongestLine = 4096;

// Throws nothing. Members that are not known are passed over; known ones of a wrong type, numbers that are not finite, and what is
// neither an answer nor a sign of life are malformed.
[[nodiscard]] std::variant<Line, Malformed> parse(std::string_view text);

// Questions, with the end of the line.
[[nodiscard]] std::string ask(std::uint64_t id, std::string_view what);
[[nodiscard]] std::string ask_hello(std::uint64_t id, double silence_s);
struct Move {
    bool is_travel = false;
    Point to = Point::Zero();  // mm, machine coordinates
    double feed_mm_per_s = 0.0;
    double acceleration_mm_per_s2 = 0.0;
    bool until_open = false;
};
[[nodiscard]] std::string ask_move(std::uint64_t id, const Move& move);
inline constexpr std::string_view kAlive = "{\"ask\":\"alive\"}\n";

}  // namespace palpate::external
