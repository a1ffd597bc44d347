// Spells the keys of one mapping out, in the order in which they are declared.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/internal/key.h"

namespace palpate::yaml {

class KeyWriter : public ReadsNothing {
public:
    using Body = std::function<void(KeyWriter&)>;
    using ElementBody = std::function<void(KeyWriter&, std::size_t)>;

    static bool wants(bool held) { return held; }
    // Throws std::invalid_argument on what YAML cannot hold.
    template <class Field, class Kind>
    void value(const Key& key, const Field& field, const Kind& kind) {
        if (const std::string text = kind.text(field); !text.empty()) add(key, text);
    }
    bool mapping(const Key& key, bool is_held, const Body& body);
    std::optional<std::size_t> word_or_mapping(const Key& key, std::span<const std::string_view> words, std::optional<std::size_t> held,
                                               const Body& body);
    void list(const Key& key, const Length& length, std::size_t held, const ElementBody& body);

    [[nodiscard]] const std::vector<std::string>& lines() const { return lines_; }

private:
    void add(const Key& key, const std::string& text) { lines_.push_back(fmt::format("{}: {}", key.name, text)); }
    // "{one: 1, two: 2}", of lines that are flows themselves.
    [[nodiscard]] std::string flow() const;
    void add_indented(const KeyWriter& inner, const std::string& first, const std::string& others);

    std::vector<std::string> lines_;
};

}  // namespace palpate::yaml
