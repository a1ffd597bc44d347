#include "config/internal/key_table.h"

#include <fmt/format.h>

#include "config/internal/kinds.h"

namespace palpate::yaml {

bool KeyTable::mapping(const Key& key, bool /*is_held*/, const Body& body) {
    add(key, "mapping", "", std::string(kMappingRange));
    KeyTable inner(docs_, path_of(key.name));
    body(inner);
    return false;  // nothing was read
}

std::optional<std::size_t> KeyTable::word_or_mapping(const Key& key, std::span<const std::string_view> words,
                                                     std::optional<std::size_t> /*held*/, const Body& body) {
    add(key, "word or mapping", "", word_or_mapping_range(words));
    KeyTable inner(docs_, path_of(key.name));
    body(inner);
    return std::nullopt;
}

void KeyTable::list(const Key& key, const Length& length, std::size_t held, const ElementBody& body) {
    add(key, "list of mappings", "[]", length_range(length));
    if (!length.is_recursive) {
        KeyTable inner(docs_, path_of(key.name) + "[]");
        body(inner, held);  // one that is not there: its defaults
    }
}

void KeyTable::add(const Key& key, const std::string& type, const std::string& default_value, const std::string& range) {
    const std::string standard = key.need == Need::required      ? "required"
                                 : key.need == Need::alternative ? "choose one"
                                 : !key.default_text.empty()     ? std::string(key.default_text)
                                                                 : default_value;
    docs_.push_back({path_of(key.name), type, std::string(key.unit), standard, range, std::string(key.meaning)});
}

std::string KeyTable::path_of(std::string_view key) const { return path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key); }

}  // namespace palpate::yaml
