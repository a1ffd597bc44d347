#include "config/editor.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "config/internal/kinds.h"
#include "config/internal/tree.h"

namespace palpate {
namespace {

using yaml::Value;

constexpr std::size_t kNone = std::string::npos;

// A form of YAML that is not edited here.
struct Unknown {};

std::vector<std::string> split(const std::string& key) {
    std::vector<std::string> parts;
    std::istringstream stream(key);
    for (std::string part; std::getline(stream, part, '.');) parts.push_back(part);
    return parts;
}

// The same values under the same keys, in any order of the keys.
bool is_same(const Value& a, const Value& b) {
    if (a.kind != b.kind || a.text != b.text || a.quoted != b.quoted || a.children.size() != b.children.size()) return false;
    for (std::size_t k = 0; k < a.children.size(); ++k) {
        const Value* const other = a.kind == Value::Kind::mapping ? b.find(a.children[k].key) : &b.children[k];
        if (other == nullptr || !is_same(a.children[k], *other)) return false;
    }
    return true;
}

// Where a key stands, as offsets in the text.
struct Place {
    std::size_t key = 0;
    std::size_t value = 0;  // of the first character behind the colon and blanks: a line's end or a comment where lines follow
    bool is_in_flow = false;
};

class Text {
public:
    Text(std::string text, const std::string& name) : text_(std::move(text)), source_(std::make_shared<const std::string>(name)) {}

    [[nodiscard]] const std::string& whole() const { return text_; }
    [[nodiscard]] Value tree() const { return yaml::parse(text_, {source_, 1}, ""); }

    void set(const KeyEdit& edit) {
        const std::vector<std::string> parts = split(edit.key);
        const Value root = tree();
        if (root.kind != Value::Kind::mapping || text_[begin_of_content()] == '{') throw Unknown{};
        const Value* node = &root;
        std::optional<Place> place;
        for (std::size_t depth = 0; depth < parts.size(); ++depth) {
            const Value* const child = node->find(parts[depth]);
            if (child == nullptr) return add(*node, place, parts, depth, edit);
            place = locate(*child, place);
            node = child;
            // Nothing, or a word, gives way to a mapping.
            if (node->kind != Value::Kind::mapping && depth + 1 < parts.size())
                return replace(*place, nested(parts, depth + 1, edit.value), {}, edit);
        }
        replace(*place, edit.value, edit.lines, edit);
    }

private:
    [[nodiscard]] std::size_t begin_of_content() const {
        std::size_t at = 0;
        while (at < text_.size() && (text_[at] == '#' || text_[at] == '\n' || text_[at] == ' ')) {
            at = text_[at] == '#' ? end_of_line(at) : at + 1;
        }
        return std::min(at, text_.size() - 1);
    }
    // "{b: {c: value}}" of the parts from that one on.
    static std::string nested(const std::vector<std::string>& parts, std::size_t from, const std::string& value) {
        std::string text = value;
        for (std::size_t k = parts.size(); k > from; --k) text = fmt::format("{{{}: {}}}", parts[k - 1], text);
        return text;
    }

    [[nodiscard]] std::size_t begin_of_line(int line) const {
        std::size_t at = 0;
        for (int k = 1; k < line; ++k) at = text_.find('\n', at) + 1;
        return at;
    }
    [[nodiscard]] std::size_t end_of_line(std::size_t at) const { return std::min(text_.find('\n', at), text_.size()); }
    [[nodiscard]] std::size_t column(std::size_t at) const { return at - (at == 0 ? 0 : text_.rfind('\n', at - 1) + 1); }
    [[nodiscard]] std::size_t skip_blanks(std::size_t at) const { return std::min(text_.find_first_not_of(' ', at), text_.size()); }
    [[nodiscard]] bool is_at_end(std::size_t at) const { return at >= text_.size() || text_[at] == '\n' || text_[at] == '#'; }

    // `parent`: of the mapping that the key stands in; nothing: the root.
    [[nodiscard]] Place locate(const Value& node, const std::optional<Place>& parent) const {
        if (parent && (parent->is_in_flow || text_[parent->value] == '{')) return locate_in_flow(node.key, parent->value);
        const std::size_t key = skip_blanks(begin_of_line(node.where.line));
        return place_of(key, node.key, false);
    }
    [[nodiscard]] Place place_of(std::size_t key, const std::string& name, bool is_in_flow) const {
        if (text_.compare(key, name.size(), name) != 0) throw Unknown{};  // in quotes, perhaps
        const std::size_t colon = skip_blanks(key + name.size());
        if (colon >= text_.size() || text_[colon] != ':') throw Unknown{};
        return {key, skip_blanks(colon + 1), is_in_flow};
    }
    // `open`: of the brace.
    [[nodiscard]] Place locate_in_flow(const std::string& name, std::size_t open) const {
        if (open >= text_.size() || text_[open] != '{') throw Unknown{};
        for (std::size_t at = open + 1; at < text_.size();) {
            at = text_.find_first_not_of(" \n,", at);
            if (at == kNone || text_[at] == '}') break;
            const std::size_t end = end_of_flow(at);
            if (text_.compare(at, name.size(), name) == 0 && text_.find_first_not_of(' ', at + name.size()) == text_.find(':', at)) {
                return place_of(at, name, true);
            }
            at = end;
        }
        throw Unknown{};
    }
    // Of what begins there: the comma, brace or bracket around it that ends it.
    [[nodiscard]] std::size_t end_of_flow(std::size_t at) const {
        int depth = 0;
        for (; at < text_.size(); ++at) {
            const char c = text_[at];
            if (c == '"' || c == '\'') {
                at = text_.find(c, at + 1);
                if (at == kNone) break;
            } else if (c == '#') {
                throw Unknown{};
            } else if (c == '{' || c == '[') {
                ++depth;
            } else if (c == '}' || c == ']') {
                if (depth == 0) return at;
                --depth;
            } else if (c == ',' && depth == 0) {
                return at;
            }
        }
        throw Unknown{};
    }

    // Behind the last line that belongs to the key, without comments and empty lines that follow.
    [[nodiscard]] std::size_t end_of_block(const Place& place) const {
        const std::size_t indent = column(place.key);
        std::size_t end = end_of_line(place.key);
        for (std::size_t line = end + 1; line < text_.size(); line = end_of_line(line) + 1) {
            const std::size_t first = skip_blanks(line);
            if (is_at_end(first)) continue;
            const bool is_item = text_.compare(first, 2, "- ") == 0;
            if (column(first) < indent || (column(first) == indent && !is_item)) break;
            end = end_of_line(line);
        }
        return end;
    }
    // " # …" at the end of the key's line, with the blanks before it.
    [[nodiscard]] std::string comment_of(const Place& place) const {
        const std::string line = text_.substr(place.value, end_of_line(place.value) - place.value);
        if (line.starts_with('#')) return "  " + line;
        char quote = 0;
        for (std::size_t k = 0; k < line.size(); ++k) {
            if (quote != 0 ? line[k] == quote : line[k] == '"' || line[k] == '\'') {
                quote = quote == 0 ? line[k] : '\0';
            } else if (quote == 0 && line.compare(k, 2, " #") == 0) {
                return line.substr(line.find_last_not_of(' ', k) + 1);
            }
        }
        return {};
    }

    void replace(const Place& place, const std::string& value, const std::vector<std::string>& lines, const KeyEdit& edit) {
        if (place.is_in_flow) {
            text_.replace(place.value, end_of_flow(place.value) - place.value, value);
            return;
        }
        const std::string kept = comment_of(place);
        const std::string key = text_.substr(place.key, text_.find(':', place.key) - place.key);
        const std::size_t end = end_of_block(place);
        text_.replace(place.key, end - place.key,
                      block(key, value, lines, kept.empty() ? with_blanks(edit.comment) : kept, column(place.key)));
    }
    static std::string with_blanks(const std::string& comment) { return comment.empty() ? comment : "  # " + comment; }
    static std::string block(const std::string& key, const std::string& value, const std::vector<std::string>& lines,
                             const std::string& comment, std::size_t indent) {
        if (lines.empty()) return fmt::format("{}: {}{}", key, value, comment);
        std::string text = fmt::format("{}:{}", key, comment);
        for (const std::string& line : lines) text += fmt::format("\n{:{}}  {}", "", indent, line);
        return text;
    }

    // The key parts[depth], and what is below it, to a mapping.
    void add(const Value& mapping, const std::optional<Place>& place, const std::vector<std::string>& parts, std::size_t depth,
             const KeyEdit& edit) {
        const bool is_last = depth + 1 == parts.size();
        const std::string value = nested(parts, depth + 1, edit.value);
        const std::vector<std::string> lines = is_last ? edit.lines : std::vector<std::string>{};
        const std::string comment = with_blanks(edit.comment);
        if (!place) {
            if (!text_.empty() && text_.back() != '\n') text_ += '\n';
            text_ += block(parts[depth], value, lines, comment, 0) + '\n';
        } else if (place->is_in_flow || text_[place->value] == '{') {
            if (text_[place->value] != '{') throw Unknown{};
            const std::size_t close = end_of_flow(place->value + 1);
            insert_in_flow(place->value, close, fmt::format("{}: {}", parts[depth], value));
        } else {
            if (!is_at_end(place->value) || mapping.children.empty()) throw Unknown{};
            const std::size_t child = skip_blanks(begin_of_line(mapping.children.front().where.line));
            text_.insert(end_of_block(*place),
                         fmt::format("\n{:{}}{}", "", column(child), block(parts[depth], value, lines, comment, column(child))));
        }
    }
    void insert_in_flow(std::size_t open, std::size_t comma_or_close, const std::string& entry) {
        std::size_t close = comma_or_close;
        while (text_[close] == ',') close = end_of_flow(close + 1);
        if (text_[close] != '}') throw Unknown{};
        const std::size_t last = text_.find_last_not_of(" \n", close - 1);
        text_.insert(last + 1, (last == open || text_[last] == ',' ? "" : ", ") + entry);
    }

    std::string text_;
    std::shared_ptr<const std::string> source_;
};

// The same in a tree. A word on the way, such as `auto`, gives way.
void set(Value& root, const KeyEdit& edit) {
    Value* at = &root;
    for (const std::string& part : split(edit.key)) {
        const auto found = std::ranges::find(at->children, part, &Value::key);
        if (found == at->children.end()) break;
        at = &*found;
        if (at->kind != Value::Kind::scalar) continue;
        at->kind = Value::Kind::null;
        at->text.clear();
        at->quoted = false;
    }
    yaml::apply_override(root, edit.key + "=" + edit.value);
}

}  // namespace

std::string edited_config(const std::string& text, const std::filesystem::path& name, const std::vector<KeyEdit>& edits) {
    Text edited(text, name.string());
    Value expected = edited.tree();
    for (const KeyEdit& edit : edits) {
        bool is_good = false;
        try {
            set(expected, edit);
            edited.set(edit);
            is_good = is_same(edited.tree(), expected);
        } catch (const Unknown&) {
            is_good = false;
        } catch (const ConfigError&) {
            is_good = false;
        }
        if (is_good) continue;
        throw ConfigError(fmt::format("{}: {}: what is there stands in a form that is not edited here; write it by hand: {}: {}",
                                      name.string(), edit.key, edit.key, edit.value));
    }
    return edited.whole();
}

std::string yaml_text(const std::string& text) { return yaml::Text::text(text); }

}  // namespace palpate
