#include "config/internal/key_reader.h"

#include <fmt/format.h>

#include <algorithm>

#include "config/internal/kinds.h"
#include "config/nearest_word.h"

namespace palpate::yaml {

namespace {

template <class Body>
void run(const Value& node, const std::string& path, const Body& body) {
    if (node.kind != Value::Kind::mapping) {
        fail(node.where, path, fmt::format("{} is not a mapping; allowed: a mapping", spell(node)));
    }
    KeyReader inner(node, path);
    body(inner);
    inner.finish();
}

}  // namespace

bool KeyReader::mapping(const Key& key, bool /*is_held*/, const Body& body) {
    const Value* node = offer(key, std::string(kMappingRange));
    if (node != nullptr) {
        run(*node, path_of(key.name), body);
    }
    return node != nullptr;
}

std::optional<std::size_t> KeyReader::word_or_mapping(const Key& key, std::span<const std::string_view> words,
                                                      std::optional<std::size_t> /*held*/, const Body& body) {
    const Value* node = offer(key, word_or_mapping_range(words));
    if (node == nullptr) {
        return std::nullopt;
    }
    if (node->kind == Value::Kind::mapping) {
        run(*node, path_of(key.name), body);
        return std::nullopt;
    }
    const std::optional<std::size_t> word = find_word(*node, words);
    if (!word) {
        refuse_word(*node, words, {path_of(key.name), fmt::format("{}, or a mapping", join(words))});
    }
    return word;
}

void KeyReader::list(const Key& key, const Length& length, std::size_t /*held*/, const ElementBody& body) {
    const std::string range = length_range(length);
    const Value* node = offer(key, range);
    if (node == nullptr) {
        return;
    }
    if (node->kind != Value::Kind::list || node->children.size() < length.least) {
        const std::string why = node->kind == Value::Kind::list ? "the list is too short" : fmt::format("{} is not a list", spell(*node));
        fail(node->where, path_of(key.name), fmt::format("{}; allowed: a list of mappings, {}", why, range));
    }
    for (std::size_t k = 0; k < node->children.size(); ++k) {
        run(node->children[k], fmt::format("{}[{}]", path_of(key.name), k), [&](KeyReader& inner) { body(inner, k); });
    }
}

void KeyReader::require_one_alternative() const {
    finish();
    std::string allowed;
    std::vector<std::string_view> present;
    for (const Offer& candidate : offers_) {
        if (candidate.need == Need::alternative) {
            allowed += (allowed.empty() ? "" : ", ") + candidate.name;
            if (has(candidate.name)) {
                present.push_back(candidate.name);
            }
        }
    }
    if (present.size() != 1) {
        const std::string what = present.empty() ? "holds none of its alternatives" : fmt::format("holds {}", join(present, " and "));
        fail(present.empty() ? node_->where : location_of(present.back()), path_,
             fmt::format("{}; allowed: exactly one of {}", what, allowed));
    }
}

void KeyReader::require(bool condition, std::string_view key, const std::string& what_and_allowed) const {
    finish();
    if (!condition) {
        fail(location_of(key), path_of(key), what_and_allowed);
    }
}

void KeyReader::finish() const {
    for (const Value& child : node_->children) {
        if (std::none_of(offers_.begin(), offers_.end(), [&](const Offer& candidate) { return candidate.name == child.key; })) {
            fail_unknown(child);
        }
    }
    for (const Offer& candidate : offers_) {
        if (candidate.need == Need::required && !has(candidate.name)) {
            fail(node_->where, path_of(candidate.name), fmt::format("is required; allowed: {}", candidate.allowed));
        }
    }
}

const Value* KeyReader::offer(const Key& key, const std::string& allowed) {
    offers_.push_back({std::string(key.name), allowed, key.need});
    return node_->find(key.name);
}

std::string KeyReader::path_of(std::string_view key) const { return path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key); }

Location KeyReader::location_of(std::string_view key) const {
    const Value* child = node_->find(key);
    return child == nullptr ? node_->where : child->where;
}

void KeyReader::fail_unknown(const Value& child) const {
    std::vector<std::string_view> known;
    for (const Offer& candidate : offers_) known.push_back(candidate.name);
    // Spelled by the same rules as a value, so that a strange key cannot garble the message.
    Value key;
    key.kind = Value::Kind::scalar;
    key.text = child.key;
    fail(child.where, path_of(spell(key)), fmt::format("unknown key{}; allowed: {}", did_you_mean(child.key, known), join(known)));
}

}  // namespace palpate::yaml
