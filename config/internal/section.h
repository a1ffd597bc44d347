// Reads the keys of one mapping, each declared where it is read: name, unit, bounds, default, meaning.
//
// The same code serves two purposes. *Reading*, a section takes values from a tree and refuses what is wrong. *Describing*,
// there is no tree: every key that the code asks for is recorded, and harmless values are returned. So the list of
// documented keys is the list of keys that are read.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/internal/tree.h"
#include "config/reader.h"
#include "planner/geometry.h"

namespace palpate::yaml {

struct Bounds {
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
    bool low_included = true;  // high always is

    [[nodiscard]] bool contain(double value) const { return (low_included ? value >= low : value > low) && value <= high; }
    [[nodiscard]] std::string text() const;  // "greater than 0"
};
constexpr Bounds kAnyNumber{};
constexpr Bounds kPositive{0.0, std::numeric_limits<double>::infinity(), false};
constexpr Bounds kNotNegative{0.0};

// Does the section have to hold the key?
enum class Need {
    required,
    optional,
    alternative,  // exactly one of the section's alternatives: see Section::require_one_alternative
};

struct Key {
    std::string_view name;
    std::string_view meaning;
    Need need = Need::optional;
    std::string_view unit{};
    std::string_view default_text{};  // documents an optional key whose default is not one value
};

class Section {
public:
    using Body = std::function<void(Section&)>;

    Section(const Value& node, std::string path) : node_(&node), path_(std::move(path)) {}          // reading
    Section(std::vector<KeyDoc>& docs, std::string path) : docs_(&docs), path_(std::move(path)) {}  // describing

    // The value of a key, or `fallback` (or an unspecified one) where it is absent; finish() complains about absent
    // keys that are required. All throw ConfigError on a wrong type and out of bounds.
    double number(const Key& key, const Bounds& bounds, std::optional<double> fallback = {});
    std::optional<double> number_or_null(const Key& key, const Bounds& bounds);
    Vector vector(const Key& key, const Bounds& each, std::optional<Vector> fallback = {});
    Vector angles(const Key& key);                        // written in degrees, returned in radians; default 0
    double angle(const Key& key, const Bounds& degrees);  // likewise, one
    std::uint64_t whole_number(const Key& key, std::uint64_t fallback);
    int whole_number(const Key& key, int low, int high, int fallback);
    bool flag(const Key& key, bool fallback);  // true or false
    std::optional<std::uint64_t> whole_number_or_null(const Key& key);
    std::string text(const Key& key);
    std::size_t word(const Key& key, std::span<const std::string_view> words, std::size_t fallback);  // index of the word

    // Runs `body` on the mapping below `key`, if there is one; returns whether there is.
    bool mapping(const Key& key, const Body& body);
    // The same, where one of `words` may stand instead; returns the index of that word, if one does.
    std::optional<std::size_t> word_or_mapping(const Key& key, std::span<const std::string_view> words, const Body& body);
    // Runs `body` on every mapping of a list. A `recursive` list holds mappings that are described elsewhere.
    void list(const Key& key, std::size_t minimum, bool recursive, const Body& body);

    [[nodiscard]] bool has(std::string_view key) const { return node_ != nullptr && node_->find(key) != nullptr; }

    // To call once all keys are read. Both complain about unknown and about missing keys first.
    void require_one_alternative();
    void require(bool condition, std::string_view key, const std::string& what_and_allowed);
    // Throws ConfigError on keys that were not asked for and on required keys that are absent.
    void finish() const;

private:
    struct Offer {
        std::string name;
        std::string allowed;
        bool required = false;
        bool alternative = false;
    };

    const Value* offer(const Key& key, const std::string& type, const std::string& fallback, const std::string& range);
    [[nodiscard]] std::string path_of(std::string_view key) const;
    [[nodiscard]] Location location_of(std::string_view key) const;
    void run(const Value& node, const std::string& path, const Body& body) const;
    [[noreturn]] void fail_unknown(const Value& child) const;

    const Value* node_ = nullptr;
    std::vector<KeyDoc>* docs_ = nullptr;
    std::string path_;
    std::vector<Offer> offers_;
};

}  // namespace palpate::yaml
