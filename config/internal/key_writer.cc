#include "config/internal/key_writer.h"

#include <fmt/format.h>

namespace palpate::yaml {

bool KeyWriter::mapping(const Key& key, bool is_held, const Body& body) {
    if (is_held) {
        KeyWriter inner;
        body(inner);
        if (key.layout == Layout::flow) {
            add(key, inner.flow());
        } else {
            lines_.push_back(fmt::format("{}:", key.name));
            add_indented(inner, "  ", "  ");
        }
    }
    return false;  // nothing was read
}

std::optional<std::size_t> KeyWriter::word_or_mapping(const Key& key, std::span<const std::string_view> words,
                                                      std::optional<std::size_t> held, const Body& body) {
    if (held) {
        add(key, std::string(words[*held]));
    } else {
        mapping(key, true, body);
    }
    return std::nullopt;
}

void KeyWriter::list(const Key& key, const Length& /*length*/, std::size_t held, const ElementBody& body) {
    lines_.push_back(fmt::format("{}:{}", key.name, held == 0 ? " []" : ""));
    for (std::size_t k = 0; k < held; ++k) {
        KeyWriter inner;
        body(inner, k);
        if (key.layout == Layout::flow) {
            lines_.push_back("  - " + inner.flow());
        } else {
            add_indented(inner, "  - ", "    ");
        }
    }
}

std::string KeyWriter::flow() const { return fmt::format("{{{}}}", fmt::join(lines_, ", ")); }

void KeyWriter::add_indented(const KeyWriter& inner, const std::string& first, const std::string& others) {
    for (const std::string& line : inner.lines_) {
        lines_.push_back((&line == &inner.lines_.front() ? first : others) + line);
    }
}

}  // namespace palpate::yaml
