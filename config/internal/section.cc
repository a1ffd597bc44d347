#include "config/internal/section.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "config/internal/numbers.h"

namespace palpate::yaml {

namespace {

// A whole turn each way is enough to write any orientation.
constexpr Bounds kAngleBounds{-360.0, 360.0};
constexpr std::string_view kDegrees = "degrees";
// Two slips of the finger are still the same word, if it is long enough.
constexpr std::size_t kMaxTypos = 2;

Vector absent_vector() { return Vector::Constant(std::numeric_limits<double>::quiet_NaN()); }

std::string with_unit(const std::string& range, std::string_view unit) {
    return unit.empty() ? range : range + " (" + std::string(unit) + ")";
}

std::string join(std::span<const std::string_view> words, const std::string& separator = ", ") {
    std::string text;
    for (const std::string_view word : words) {
        text += (text.empty() ? "" : separator) + std::string(word);
    }
    return text;
}

std::string vector_text(const Vector& v) { return "[" + number_text(v.x()) + ", " + number_text(v.y()) + ", " + number_text(v.z()) + "]"; }

// Levenshtein's: how many letters to insert, remove or replace.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
        }
    }
    return row[b.size()];
}

// The three elements of a vector, each handed to `read` with its own path.
template <class Read>
Vector read_vector(const Value& node, const std::string& path, const std::string& allowed, const Read& read) {
    if (node.kind != Value::Kind::list || node.children.size() != 3) {
        const std::string count = node.kind == Value::Kind::list ? " of " + std::to_string(node.children.size()) : "";
        fail(node.where, path, spell(node) + count + " is not a list of three numbers; allowed: " + allowed);
    }
    Vector result;
    for (int i = 0; i < 3; ++i) {
        result[i] = read(node.children[static_cast<std::size_t>(i)], path + "[" + std::to_string(i) + "]");
    }
    return result;
}

}  // namespace

std::string Bounds::text() const {
    const std::string from = low_included ? "at least " : "greater than ";
    if (high < std::numeric_limits<double>::infinity()) {
        return low_included ? "from " + number_text(low) + " to " + number_text(high)
                            : from + number_text(low) + ", at most " + number_text(high);
    }
    return low > -std::numeric_limits<double>::infinity() ? from + number_text(low) : "any number";
}

double Section::number(const Key& key, const Bounds& bounds, std::optional<double> fallback) {
    const Value* node = offer(key, "number", fallback ? number_text(*fallback) : "", bounds.text());
    if (node == nullptr) {
        return fallback.value_or(std::numeric_limits<double>::quiet_NaN());
    }
    const std::string allowed = with_unit(bounds.text(), key.unit);
    const double value = read_number(*node, path_of(key.name), allowed);
    if (!bounds.contain(value)) {
        fail(node->where, path_of(key.name), spell(*node) + " is out of range; allowed: " + allowed);
    }
    return value;
}

std::optional<double> Section::number_or_null(const Key& key, const Bounds& bounds) {
    const std::string range = bounds.text() + ", or null";
    const Value* node = offer(key, "number or null", "null", range);
    if (node == nullptr || node->kind == Value::Kind::null) {
        return std::nullopt;
    }
    const std::string allowed = with_unit(bounds.text(), key.unit) + ", or null";
    const double value = read_number(*node, path_of(key.name), allowed);
    if (!bounds.contain(value)) {
        fail(node->where, path_of(key.name), spell(*node) + " is out of range; allowed: " + allowed);
    }
    return value;
}

Vector Section::vector(const Key& key, const Bounds& each, std::optional<Vector> fallback) {
    const Value* node = offer(key, "list of 3 numbers", fallback ? vector_text(*fallback) : "", each.text());
    if (node == nullptr) {
        return fallback.value_or(absent_vector());
    }
    const std::string allowed = with_unit(each.text(), key.unit);
    return read_vector(*node, path_of(key.name), "[x, y, z], each " + allowed, [&](const Value& element, const std::string& path) {
        const double value = read_number(element, path, allowed);
        if (!each.contain(value)) {
            fail(element.where, path, spell(element) + " is out of range; allowed: " + allowed);
        }
        return value;
    });
}

Vector Section::angles(const Key& key) {
    Key in_degrees = key;
    in_degrees.unit = kDegrees;
    const Value* node = offer(in_degrees, "list of 3 numbers", vector_text(Vector::Zero()), kAngleBounds.text());
    if (node == nullptr) {
        return Vector::Zero();
    }
    const std::string allowed = with_unit(kAngleBounds.text(), kDegrees);
    return read_vector(*node, path_of(key.name), "[x, y, z], each " + allowed,
                       [&](const Value& element, const std::string& path) { return read_degrees(element, kAngleBounds, path, allowed); });
}

double Section::angle(const Key& key, const Bounds& degrees) {
    Key in_degrees = key;
    in_degrees.unit = kDegrees;
    const Value* node = offer(in_degrees, "number", "0", degrees.text());
    return node == nullptr ? 0.0 : read_degrees(*node, degrees, path_of(key.name), with_unit(degrees.text(), kDegrees));
}

std::optional<std::uint64_t> Section::whole_number_or_null(const Key& key) {
    const std::string range = "from 0 to " + std::to_string(std::numeric_limits<std::uint64_t>::max()) + ", or null";
    const Value* node = offer(key, "whole number or null", "null", range);
    if (node == nullptr || node->kind == Value::Kind::null) {
        return std::nullopt;
    }
    return read_whole_number(*node, path_of(key.name), with_unit(range, key.unit));
}

std::uint64_t Section::whole_number(const Key& key, std::uint64_t fallback) {
    const std::string range = "from 0 to " + std::to_string(std::numeric_limits<std::uint64_t>::max());
    const Value* node = offer(key, "whole number", std::to_string(fallback), range);
    return node == nullptr ? fallback : read_whole_number(*node, path_of(key.name), with_unit(range, key.unit));
}

int Section::whole_number(const Key& key, int low, int high, int fallback) {
    const std::string range = "from " + std::to_string(low) + " to " + std::to_string(high);
    const Value* node = offer(key, "whole number", std::to_string(fallback), range);
    if (node == nullptr) {
        return fallback;
    }
    const std::uint64_t value = read_whole_number(*node, path_of(key.name), with_unit(range, key.unit));
    if (value < static_cast<std::uint64_t>(low) || value > static_cast<std::uint64_t>(high)) {
        fail(node->where, path_of(key.name), spell(*node) + " is out of range; allowed: " + range);
    }
    return static_cast<int>(value);
}

bool Section::flag(const Key& key, bool fallback) {
    static constexpr std::array<std::string_view, 2> kWords{"false", "true"};
    return word(key, kWords, fallback ? 1 : 0) == 1;
}

std::string Section::text(const Key& key) {
    const std::string range = "a text that is not empty";
    const Value* node = offer(key, "text", std::string(key.default_text), range);
    if (node == nullptr) {
        return {};
    }
    if (node->kind != Value::Kind::scalar) {
        fail(node->where, path_of(key.name), spell(*node) + " is not a text; allowed: " + range);
    }
    if (node->text.empty() || node->text.find('\0') != std::string::npos) {
        fail(node->where, path_of(key.name), spell(*node) + " is empty or holds a zero byte; allowed: " + range);
    }
    return node->text;
}

std::size_t Section::word(const Key& key, std::span<const std::string_view> words, std::size_t fallback) {
    const std::string range = join(words);
    const Value* node = offer(key, "word", std::string(words[fallback]), range);
    if (node == nullptr) {
        return fallback;
    }
    const auto found = std::find(words.begin(), words.end(), node->text);
    if (node->kind != Value::Kind::scalar || found == words.end()) {
        fail(node->where, path_of(key.name), spell(*node) + " is not one of the words; allowed: " + range);
    }
    return static_cast<std::size_t>(found - words.begin());
}

bool Section::mapping(const Key& key, const Body& body) {
    const Value* node = offer(key, "mapping", std::string(key.default_text), "a mapping of the keys below it");
    if (docs_ != nullptr) {
        Section section(*docs_, path_of(key.name));
        body(section);
    } else if (node != nullptr) {
        run(*node, path_of(key.name), body);
    }
    return node != nullptr;
}

std::optional<std::size_t> Section::word_or_mapping(const Key& key, std::span<const std::string_view> words, const Body& body) {
    const std::string range = join(words) + ", or a mapping of the keys below it";
    const Value* node = offer(key, "word or mapping", std::string(key.default_text), range);
    if (docs_ != nullptr) {
        Section section(*docs_, path_of(key.name));
        body(section);
    }
    if (node == nullptr) {
        return std::nullopt;
    }
    if (node->kind == Value::Kind::mapping) {
        run(*node, path_of(key.name), body);
        return std::nullopt;
    }
    const auto found = std::find(words.begin(), words.end(), node->text);
    if (node->kind != Value::Kind::scalar || found == words.end()) {
        fail(node->where, path_of(key.name), spell(*node) + " is not one of the words; allowed: " + join(words) + ", or a mapping");
    }
    return static_cast<std::size_t>(found - words.begin());
}

void Section::list(const Key& key, std::size_t minimum, bool recursive, const Body& body) {
    const std::string range = minimum > 0 ? "at least " + std::to_string(minimum) : "any length";
    const Value* node = offer(key, "list of mappings", minimum > 0 ? "" : "[]", range);
    if (docs_ != nullptr && !recursive) {
        Section section(*docs_, path_of(key.name) + "[]");
        body(section);
    }
    if (node == nullptr) {
        return;
    }
    if (node->kind != Value::Kind::list || node->children.size() < minimum) {
        const std::string why = node->kind == Value::Kind::list ? "the list is too short" : spell(*node) + " is not a list";
        fail(node->where, path_of(key.name), why + "; allowed: a list of mappings, " + range);
    }
    for (std::size_t i = 0; i < node->children.size(); ++i) {
        run(node->children[i], path_of(key.name) + "[" + std::to_string(i) + "]", body);
    }
}

void Section::require_one_alternative() {
    if (node_ == nullptr) {
        return;
    }
    finish();
    std::string allowed;
    std::vector<std::string_view> present;
    for (const Offer& candidate : offers_) {
        if (candidate.alternative) {
            allowed += (allowed.empty() ? "" : ", ") + candidate.name;
            if (node_->find(candidate.name) != nullptr) {
                present.push_back(candidate.name);
            }
        }
    }
    if (present.size() != 1) {
        const std::string what = present.empty() ? "holds none of its alternatives" : "holds " + join(present, " and ");
        fail(present.empty() ? node_->where : location_of(present.back()), path_, what + "; allowed: exactly one of " + allowed);
    }
}

void Section::require(bool condition, std::string_view key, const std::string& what_and_allowed) {
    if (node_ != nullptr) {
        finish();
        if (!condition) {
            fail(location_of(key), path_of(key), what_and_allowed);
        }
    }
}

void Section::finish() const {
    if (node_ == nullptr) {
        return;
    }
    for (const Value& child : node_->children) {
        if (std::none_of(offers_.begin(), offers_.end(), [&](const Offer& candidate) { return candidate.name == child.key; })) {
            fail_unknown(child);
        }
    }
    for (const Offer& candidate : offers_) {
        if (candidate.required && node_->find(candidate.name) == nullptr) {
            fail(node_->where, path_of(candidate.name), "is required; allowed: " + candidate.allowed);
        }
    }
}

const Value* Section::offer(const Key& key, const std::string& type, const std::string& fallback, const std::string& range) {
    offers_.push_back({std::string(key.name), with_unit(range, key.unit), key.need == Need::required, key.need == Need::alternative});
    if (docs_ != nullptr) {
        const std::string standard = key.need == Need::required      ? "required"
                                     : key.need == Need::alternative ? "choose one"
                                     : !key.default_text.empty()     ? std::string(key.default_text)
                                                                     : fallback;
        docs_->push_back({path_of(key.name), type, std::string(key.unit), standard, range, std::string(key.meaning)});
        return nullptr;
    }
    return node_->find(key.name);
}

std::string Section::path_of(std::string_view key) const { return path_.empty() ? std::string(key) : path_ + "." + std::string(key); }

Location Section::location_of(std::string_view key) const {
    const Value* child = node_->find(key);
    return child == nullptr ? node_->where : child->where;
}

void Section::run(const Value& node, const std::string& path, const Body& body) const {
    if (node.kind != Value::Kind::mapping) {
        fail(node.where, path, spell(node) + " is not a mapping; allowed: a mapping");
    }
    Section section(node, path);
    body(section);
    section.finish();
}

void Section::fail_unknown(const Value& child) const {
    std::string nearest;
    std::size_t typos = kMaxTypos + 1;
    std::string allowed;
    for (const Offer& candidate : offers_) {
        allowed += (allowed.empty() ? "" : ", ") + candidate.name;
        const std::size_t distance = edit_distance(child.key.substr(0, 64), candidate.name);
        if (distance < typos && distance < candidate.name.size()) {
            typos = distance;
            nearest = candidate.name;
        }
    }
    const std::string hint = nearest.empty() ? "" : "; did you mean \"" + nearest + "\"?";
    // Spelled by the same rules as a value, so that a strange key cannot garble the message.
    Value key;
    key.kind = Value::Kind::scalar;
    key.text = child.key;
    fail(child.where, path_of(spell(key)), "unknown key" + hint + "; allowed: " + allowed);
}

}  // namespace palpate::yaml
