// A YAML text as a tree of values that know where they were written.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "config/config_error.h"

namespace palpate::yaml {

// Larger texts and deeper nesting are refused: no session needs them, and every later step may recurse.
constexpr std::size_t kMaxBytes = std::size_t{1} << 20U;
constexpr std::size_t kMaxDepth = 64;

struct Location {
    std::shared_ptr<const std::string> source;  // a file's name, or "--set key=value"
    int line = 0;                               // from 1; 0: the source as a whole
};

struct Value {
    enum class Kind { null, scalar, list, mapping };

    Kind kind = Kind::null;
    std::string key;  // within a mapping; empty for the root and for elements of a list
    Location where;   // of the key, of the value where there is no key
    std::string text;
    bool quoted = false;  // a quoted scalar is always text, never a number or a keyword
    std::vector<Value> children;

    // Throws nothing; null where this is no mapping or has no such key.
    [[nodiscard]] const Value* find(std::string_view name) const;
};

// Throws ConfigError `where: key: what`; `key` may be empty.
[[noreturn]] void fail(const Location& where, std::string_view key, const std::string& what);

// What to call a value in a message: its text, shortened; "a list"; …
[[nodiscard]] std::string spell(const Value& node);

// Parses a text of exactly one document. `path` is the full key that the text is the value of. Where `where.line` is 0,
// all nodes have that location; otherwise lines count from `where.line`.
// Throws ConfigError on syntax errors, duplicate keys, keys that are not scalars, anchors, aliases, tags, no or several
// documents, and beyond the limits above.
[[nodiscard]] Value parse(const std::string& text, const Location& where, const std::string& path);

// Puts "a.b.c=value" into the mapping `root`, making mappings on the way where there is nothing yet.
// Throws ConfigError when the assignment is malformed or goes through something that is not a mapping.
void apply_override(Value& root, const std::string& assignment);

}  // namespace palpate::yaml
