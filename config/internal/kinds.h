// What the value of a key may be. Every kind has
//   type()                    for the table: "list of 3 numbers"
//   range(unit)               what is allowed: "greater than 0 (mm)" in messages, without a unit in the table
//   read(node, spot, field)   throws ConfigError on a wrong type and out of range
//   text(field)               what `read` turns back into the field, bit for bit; empty: the key is not written. Throws
//                             std::invalid_argument on what YAML cannot hold
#pragma once

#include <fmt/format.h>

#include <array>
#include <concepts>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/internal/key.h"
#include "config/internal/numbers.h"
#include "config/internal/tree.h"
#include "planner/geometry.h"
#include "planner/machine_time.h"

namespace palpate::yaml {

inline constexpr std::string_view kMillimetres = "mm";
inline constexpr std::string_view kDegrees = "degrees";
inline constexpr std::string_view kSeconds = "s";

// "a, b"
[[nodiscard]] std::string join(std::span<const std::string_view> words, std::string_view separator = ", ");
// What is allowed for keys that have other keys below them.
inline constexpr std::string_view kMappingRange = "a mapping of the keys below it";
[[nodiscard]] std::string word_or_mapping_range(std::span<const std::string_view> words);
[[nodiscard]] std::string length_range(const Length& length);
// Which of the words `node` is; nothing if it is none.
[[nodiscard]] std::optional<std::size_t> find_word(const Value& node, std::span<const std::string_view> words);
// Throws ConfigError that proposes the word which `node` probably means.
[[noreturn]] void refuse_word(const Value& node, std::span<const std::string_view> words, const Spot& spot);
// Throws ConfigError if `node` is no list of three.
void require_triple(const Value& node, const Spot& spot);
// Throws ConfigError if `node` is no list.
void require_list(const Value& node, const Spot& spot);
// Throws ConfigError if `node` is no list of so many.
void require_row(const Value& node, const Spot& spot, std::size_t count);

struct Number {
    Bounds bounds;

    [[nodiscard]] static std::string type() { return "number"; }
    [[nodiscard]] std::string range(std::string_view unit) const { return with_unit(bounds.text(), unit); }
    void read(const Value& node, const Spot& spot, double& field) const { field = read_number(node, bounds, spot); }
    void read(const Value& node, const Spot& spot, Seconds& field) const { field = Seconds(read_number(node, bounds, spot)); }
    [[nodiscard]] static std::string text(double field) { return number_text(field); }
    [[nodiscard]] static std::string text(Seconds field) { return number_text(field.count()); }
};

// Radians in a field, degrees in a file: the unit of its keys is kDegrees.
struct Angle {
    Bounds degrees{-360.0, 360.0};  // a whole turn each way is enough to write any orientation

    [[nodiscard]] static std::string type() { return "number"; }
    [[nodiscard]] std::string range(std::string_view unit) const { return with_unit(degrees.text(), unit); }
    void read(const Value& node, const Spot& spot, double& field) const { field = read_degrees(node, degrees, spot); }
    [[nodiscard]] static std::string text(double field) { return degrees_text(field); }
};

// Along x, y and z.
template <class Each>
struct Triple {
    Each each;

    [[nodiscard]] static std::string type() { return "list of 3 numbers"; }
    [[nodiscard]] std::string range(std::string_view unit) const { return each.range(unit); }
    void read(const Value& node, const Spot& spot, Vector& field) const {
        require_triple(node, spot);
        for (int i = 0; i < 3; ++i) {
            each.read(node.children[static_cast<std::size_t>(i)], {fmt::format("{}[{}]", spot.path, i), spot.allowed}, field[i]);
        }
    }
    [[nodiscard]] std::string text(const Vector& field) const {
        return fmt::format("[{}, {}, {}]", each.text(field.x()), each.text(field.y()), each.text(field.z()));
    }
};
template <class Each>
Triple(Each) -> Triple<Each>;

// Points in a plane, x and y each.
template <class Each>
struct FlatPoints {
    Each each;

    [[nodiscard]] static std::string type() { return "list of pairs of numbers"; }
    [[nodiscard]] std::string range(std::string_view unit) const { return each.range(unit); }
    void read(const Value& node, const Spot& spot, std::vector<Eigen::Vector2d>& field) const {
        require_list(node, spot);
        field.clear();
        for (std::size_t k = 0; k < node.children.size(); ++k) {
            const std::string path = fmt::format("{}[{}]", spot.path, k);
            require_row(node.children[k], {path, spot.allowed}, 2);
            for (const std::size_t i : {0U, 1U}) {
                double coordinate = 0;
                each.read(node.children[k].children[i], {fmt::format("{}[{}]", path, i), spot.allowed}, coordinate);
                (i == 0 ? field.emplace_back().x() : field.back().y()) = coordinate;
            }
        }
    }
    [[nodiscard]] std::string text(const std::vector<Eigen::Vector2d>& field) const {
        std::string points;
        for (const Eigen::Vector2d& p : field) {
            points += fmt::format("{}[{}, {}]", points.empty() ? "" : ", ", each.text(p.x()), each.text(p.y()));
        }
        return fmt::format("[{}]", points);
    }
};
template <class Each>
FlatPoints(Each) -> FlatPoints<Each>;

template <std::size_t kCount, class Each>
struct Row {
    Each each;

    [[nodiscard]] static std::string type() { return fmt::format("list of {} numbers", kCount); }
    [[nodiscard]] std::string range(std::string_view unit) const { return each.range(unit); }
    void read(const Value& node, const Spot& spot, std::array<double, kCount>& field) const {
        require_row(node, spot, kCount);
        for (std::size_t i = 0; i < kCount; ++i)
            each.read(node.children[i], {fmt::format("{}[{}]", spot.path, i), spot.allowed}, field.at(i));
    }
    [[nodiscard]] std::string text(const std::array<double, kCount>& field) const {
        std::string numbers;
        for (const double number : field) numbers += (numbers.empty() ? "" : ", ") + each.text(number);
        return fmt::format("[{}]", numbers);
    }
};

struct Whole {
    std::uint64_t low = 0;
    std::uint64_t high = std::numeric_limits<std::uint64_t>::max();

    [[nodiscard]] static std::string type() { return "whole number"; }
    [[nodiscard]] std::string range(std::string_view unit) const { return with_unit(fmt::format("from {} to {}", low, high), unit); }
    template <std::integral Integer>
    void read(const Value& node, const Spot& spot, Integer& field) const {
        field = static_cast<Integer>(read_whole_number(node, low, high, spot));
    }
    template <std::integral Integer>
    [[nodiscard]] static std::string text(Integer field) {
        return std::to_string(field);
    }
};

template <class Kind>
struct OrNull {
    Kind kind;

    [[nodiscard]] static std::string type() { return Kind::type() + " or null"; }
    [[nodiscard]] std::string range(std::string_view unit) const { return kind.range(unit) + ", or null"; }
    template <class Field>
    void read(const Value& node, const Spot& spot, std::optional<Field>& field) const {
        if (node.kind == Value::Kind::null) {
            field.reset();
        } else {
            kind.read(node, spot, field.emplace());
        }
    }
    template <class Field>
    [[nodiscard]] std::string text(const std::optional<Field>& field) const {
        return field ? kind.text(*field) : "null";
    }
};
template <class Kind>
OrNull(Kind) -> OrNull<Kind>;

// The words of an enumeration, in the order of its enumerators; or of an index.
struct Word {
    std::span<const std::string_view> words;

    [[nodiscard]] static std::string type() { return "word"; }
    [[nodiscard]] std::string range(std::string_view /*unit*/) const { return join(words); }
    template <class Option>
    void read(const Value& node, const Spot& spot, Option& field) const {
        field = static_cast<Option>(index_of(node, spot));
    }
    template <class Option>
    [[nodiscard]] std::string text(Option field) const {
        return word_at(static_cast<std::size_t>(field));
    }
    [[nodiscard]] std::size_t index_of(const Value& node, const Spot& spot) const;
    [[nodiscard]] std::string word_at(std::size_t index) const;
};

inline constexpr std::array<std::string_view, 2> kFlagWords{"false", "true"};
inline constexpr Word kFlag{kFlagWords};

struct Text {
    [[nodiscard]] static std::string type() { return "text"; }
    [[nodiscard]] static std::string range(std::string_view /*unit*/) { return "a text that is not empty"; }
    static void read(const Value& node, const Spot& spot, std::string& field);
    [[nodiscard]] static std::string text(const std::string& field);
};

// The same; none, no key.
struct TextOrNone {
    [[nodiscard]] static std::string type() { return Text::type(); }
    [[nodiscard]] static std::string range(std::string_view unit) { return Text::range(unit); }
    static void read(const Value& node, const Spot& spot, std::string& field) { Text::read(node, spot, field); }
    [[nodiscard]] static std::string text(const std::string& field) { return field.empty() ? "" : Text::text(field); }
};

// A list of them, as the words of a command.
struct Texts {
    [[nodiscard]] static std::string type() { return "list of texts"; }
    [[nodiscard]] static std::string range(std::string_view /*unit*/) { return "at least one, none of them empty"; }
    static void read(const Value& node, const Spot& spot, std::vector<std::string>& field);
    // None, no key.
    [[nodiscard]] static std::string text(const std::vector<std::string>& field);
};

// As it stands in the file; whoever knows the file's folder makes it absolute. No name, no key.
struct File {
    [[nodiscard]] static std::string type() { return Text::type(); }
    [[nodiscard]] static std::string range(std::string_view unit) { return Text::range(unit); }
    static void read(const Value& node, const Spot& spot, std::filesystem::path& field);
    [[nodiscard]] static std::string text(const std::filesystem::path& field);
};

}  // namespace palpate::yaml
