// Notes what there is to know of each key of a mapping. No fields are set, and none but defaults are read.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/internal/key.h"
#include "config/key_docs.h"

namespace palpate::yaml {

class KeyTable : public ReadsNothing {
public:
    using Body = std::function<void(KeyTable&)>;
    using ElementBody = std::function<void(KeyTable&, std::size_t)>;

    // `docs` must outlive this.
    KeyTable(std::vector<KeyDoc>& docs, std::string path) : docs_(docs), path_(std::move(path)) {}

    template <class Field, class Kind>
    void value(const Key& key, const Field& field, const Kind& kind) {
        const bool is_shown = key.need == Need::optional && key.default_text.empty();
        add(key, kind.type(), is_shown ? kind.text(field) : "", kind.range(""));
    }
    bool mapping(const Key& key, bool is_held, const Body& body);
    std::optional<std::size_t> word_or_mapping(const Key& key, std::span<const std::string_view> words, std::optional<std::size_t> held,
                                               const Body& body);
    void list(const Key& key, const Length& length, std::size_t held, const ElementBody& body);

private:
    void add(const Key& key, const std::string& type, const std::string& default_value, const std::string& range);
    [[nodiscard]] std::string path_of(std::string_view key) const;

    std::vector<KeyDoc>& docs_;
    std::string path_;
};

}  // namespace palpate::yaml
