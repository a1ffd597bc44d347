// Reads the keys of one mapping from a tree. Strict: what is not declared, or not as declared, is refused.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/internal/key.h"
#include "config/internal/numbers.h"
#include "config/internal/tree.h"

namespace palpate::yaml {

class KeyReader {
public:
    using Body = std::function<void(KeyReader&)>;
    using ElementBody = std::function<void(KeyReader&, std::size_t)>;

    KeyReader(const Value& node, std::string path) : node_(&node), path_(std::move(path)) {}

    // Sets the field, or leaves it as it is where the key is absent; finish() complains about absent keys that are required. This and what
    // follows throw ConfigError on a wrong type and out of range.
    template <class Field, class Kind>
    void value(const Key& key, Field& field, const Kind& kind) {
        const std::string allowed = kind.range(key.unit);
        if (const Value* const node = offer(key, allowed)) kind.read(*node, {path_of(key.name), allowed}, field);
    }
    bool mapping(const Key& key, bool is_held, const Body& body);
    std::optional<std::size_t> word_or_mapping(const Key& key, std::span<const std::string_view> words, std::optional<std::size_t> held,
                                               const Body& body);
    void list(const Key& key, const Length& length, std::size_t held, const ElementBody& body);

    static bool wants(bool /*held*/) { return true; }
    [[nodiscard]] bool has(std::string_view key) const { return node_->find(key) != nullptr; }

    // To call once all keys are read. Both complain about unknown and about missing keys first.
    void require_one_alternative() const;
    void require(bool condition, std::string_view key, const std::string& what_and_allowed) const;
    // Throws ConfigError on keys that were not asked for and on required keys that are absent.
    void finish() const;

private:
    struct Offer {
        std::string name;
        std::string allowed;
        Need need;
    };

    const Value* offer(const Key& key, const std::string& allowed);
    [[nodiscard]] std::string path_of(std::string_view key) const;
    [[nodiscard]] Location location_of(std::string_view key) const;
    [[noreturn]] void fail_unknown(const Value& child) const;

    const Value* node_;
    std::string path_;
    std::vector<Offer> offers_;
};

}  // namespace palpate::yaml
