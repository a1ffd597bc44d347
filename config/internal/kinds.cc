#include "config/internal/kinds.h"

#include <fmt/format.h>
#include <utf8.h>

#include <algorithm>
#include <stdexcept>

#include "config/nearest_word.h"

namespace palpate::yaml {

std::string join(std::span<const std::string_view> words, std::string_view separator) {
    return fmt::format("{}", fmt::join(words, separator));
}

std::string word_or_mapping_range(std::span<const std::string_view> words) { return fmt::format("{}, or {}", join(words), kMappingRange); }

std::string length_range(const Length& length) { return length.least > 0 ? fmt::format("at least {}", length.least) : "any length"; }

std::optional<std::size_t> find_word(const Value& node, std::span<const std::string_view> words) {
    const auto found = std::find(words.begin(), words.end(), node.text);
    if (node.kind != Value::Kind::scalar || found == words.end()) {
        return std::nullopt;
    }
    return static_cast<std::size_t>(found - words.begin());
}

void refuse_word(const Value& node, std::span<const std::string_view> words, const Spot& spot) {
    const std::string proposal = node.kind == Value::Kind::scalar ? did_you_mean(node.text, words) : "";
    refuse(node, spot, fmt::format("is not one of the words{}", proposal));
}

void require_triple(const Value& node, const Spot& spot) {
    if (node.kind != Value::Kind::list || node.children.size() != 3) {
        const std::string count = node.kind == Value::Kind::list ? fmt::format(" of {}", node.children.size()) : "";
        fail(node.where, spot.path,
             fmt::format("{}{} is not a list of three numbers; allowed: [x, y, z], each {}", spell(node), count, spot.allowed));
    }
}

void require_list(const Value& node, const Spot& spot) {
    if (node.kind == Value::Kind::list) return;
    fail(node.where, spot.path,
         fmt::format("{} is not a list of pairs; allowed: [[x, y], ...], each number {}", spell(node), spot.allowed));
}

void require_row(const Value& node, const Spot& spot, std::size_t count) {
    if (node.kind == Value::Kind::list && node.children.size() == count) return;
    const std::string length = node.kind == Value::Kind::list ? fmt::format(" of {}", node.children.size()) : "";
    fail(node.where, spot.path,
         fmt::format("{}{} is not a list of {} numbers; allowed: {} numbers in brackets, each {}", spell(node), length, count, count,
                     spot.allowed));
}

std::size_t Word::index_of(const Value& node, const Spot& spot) const {
    const std::optional<std::size_t> found = find_word(node, words);
    if (!found) {
        refuse_word(node, words, spot);
    }
    return *found;
}

std::string Word::word_at(std::size_t index) const {
    if (index >= words.size()) {
        throw std::invalid_argument(fmt::format("there is no word for a value; the words are {}", join(words)));
    }
    return std::string(words[index]);
}

void Text::read(const Value& node, const Spot& spot, std::string& field) {
    if (node.kind != Value::Kind::scalar) {
        refuse(node, spot, "is not a text");
    }
    if (node.text.empty() || node.text.find('\0') != std::string::npos) {
        refuse(node, spot, "is empty or holds a zero byte");
    }
    field = node.text;
}

std::string Text::text(const std::string& field) {
    if (!utf8::is_valid(field)) {
        throw std::invalid_argument(fmt::format("the file name \"{}\" is not UTF-8, so YAML cannot hold it", field));
    }
    std::string result = "\"";
    for (const char c : field) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\') {
            result += fmt::format("\\{}", c);
        } else if (byte < 0x20U || byte == 0x7FU) {
            result += fmt::format("\\x{:02x}", byte);
        } else {
            result += c;
        }
    }
    return result + "\"";
}

void Texts::read(const Value& node, const Spot& spot, std::vector<std::string>& field) {
    if (node.kind != Value::Kind::list || node.children.empty()) refuse(node, spot, "is not a list of texts");
    field.clear();
    for (const Value& child : node.children) Text::read(child, spot, field.emplace_back());
}

std::string Texts::text(const std::vector<std::string>& field) {
    if (field.empty()) return "";
    std::vector<std::string> quoted;
    for (const std::string& text : field) quoted.push_back(Text::text(text));
    return fmt::format("[{}]", fmt::join(quoted, ", "));
}

void File::read(const Value& node, const Spot& spot, std::filesystem::path& field) {
    std::string name;
    Text::read(node, spot, name);
    field = name;
}

std::string File::text(const std::filesystem::path& field) { return field.empty() ? "" : Text::text(field.string()); }

}  // namespace palpate::yaml
