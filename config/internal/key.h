// How the keys of a configuration are declared: once, by functions that serve reading, writing and documenting alike.
//
//   template <class Archive>
//   void describe(Archive& keys, TorusSpec& torus) {
//       keys.value({"major", "radius of the circle …", Need::required, "mm"}, torus.major, Number{kPositive});
//       …
//       keys.require(torus.minor < torus.major, "minor", "is not less than major; allowed: …");
//   }
//
// An archive goes through the keys in the order of the calls: KeyReader fills the fields from a tree and refuses what is wrong, KeyWriter
// spells them out, KeyTable notes what there is to know of each key. All have
//   value(key, field, kind)                      kind: one of kinds.h
//   mapping(key, is_held, body)                  runs body(archive) on the mapping below the key; is_held: whether there is one to write.
//                                                Returns whether one was read
//   word_or_mapping(key, words, held, body)      the same, where a word may stand instead: `held` is to be written. Returns the one read
//   list(key, length, held, body)                runs body(archive, k) on every mapping of a list; `held`: so many are to be written
//   wants(held)                                  are keys gone through that are left out where they hold nothing? `held`: they do. Only the
//                                                writer leaves any out
//   has(key), require(condition, key, message), require_one_alternative()     for the reader alone: see there
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace palpate::yaml {

// Does the mapping have to hold the key?
enum class Need {
    required,
    optional,
    alternative,  // exactly one of the mapping's alternatives: see KeyReader::require_one_alternative
};

// How a mapping is written: {on: one, line: 1}, or each key on a line of its own. Nothing below a flow is a block.
enum class Layout { flow, block };

struct Key {
    std::string_view name;
    std::string_view meaning;
    Need need = Need::optional;
    std::string_view unit{};
    std::string_view default_text{};  // documents an optional key whose default is not the value of its field
    Layout layout = Layout::flow;     // of the mapping below it, or of each in the list
};

struct Length {
    std::size_t least = 0;
    bool is_recursive = false;  // its mappings are documented where they are declared
};

// An archive that reads nothing has nothing to refuse: what all others than the reader answer to what is for it alone.
struct ReadsNothing {
    static bool wants(bool /*held*/) { return true; }
    static bool has(std::string_view /*key*/) { return false; }
    static void require_one_alternative() {}
    static void require(bool /*condition*/, std::string_view /*key*/, std::string_view /*what_and_allowed*/) {}
};

// A mapping whose keys are those of `value`.
template <class Archive, class Value>
void mapping(Archive& keys, const Key& key, Value& value) {
    keys.mapping(key, true, [&](Archive& inner) { describe(inner, value); });
}

// The same, if it is there.
template <class Archive, class Value>
void mapping(Archive& keys, const Key& key, std::optional<Value>& value) {
    Value inside = value.value_or(Value{});
    if (keys.mapping(key, value.has_value(), [&](Archive& inner) { describe(inner, inside); })) value = std::move(inside);
}

// The same, if `which` is of that kind.
template <class Kind, class Archive, class... Kinds>
void alternative(Archive& keys, Key key, std::variant<Kinds...>& which) {
    key.need = Need::alternative;
    const Kind* const held = std::get_if<Kind>(&which);
    Kind kind = held != nullptr ? *held : Kind{};
    if (keys.mapping(key, held != nullptr, [&](Archive& inner) { describe(inner, kind); })) which = std::move(kind);
}

template <class Archive, class Value>
void list(Archive& keys, const Key& key, const Length& length, std::vector<Value>& values) {
    keys.list(key, length, values.size(), [&](Archive& inner, std::size_t k) {
        if (k == values.size()) values.emplace_back();
        describe(inner, values[k]);
    });
}

}  // namespace palpate::yaml
