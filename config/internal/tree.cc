#include "config/internal/tree.h"

#include <fmt/format.h>
#include <utf8.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

namespace palpate::yaml {

namespace {

// Long enough to recognise a value in a message, short enough for one line.
constexpr std::size_t kMaxSpelledBytes = 60;

std::string shorten(const std::string& text) {
    std::string result;
    for (const char c : text) {
        if (result.size() >= kMaxSpelledBytes) {
            // Never cut a UTF-8 character: continuation bytes read 10xxxxxx.
            if ((static_cast<unsigned char>(c) & 0xC0U) != 0x80U) {
                return result + "...";
            }
        }
        const bool control = static_cast<unsigned char>(c) < 0x20U || c == 0x7F;
        result += control ? '?' : c;
    }
    return result;
}

// Builds the tree from yaml-cpp's events. Its own tree is not used: it accepts duplicate keys, loses the lines of keys
// and expands aliases.
class TreeBuilder final : public YAML::EventHandler {
public:
    TreeBuilder(Location base, std::string path) : base_(std::move(base)), path_(std::move(path)) {}

    [[nodiscard]] std::optional<Value>& root() { return root_; }

    void OnDocumentStart(const YAML::Mark& mark) override {
        if (++documents_ > 1) {
            fail(at(mark), path_, "a second document starts here; allowed: exactly one");
        }
    }
    void OnDocumentEnd() override {}

    void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
        refuse_extras(mark, anchor, "");
        add(make(mark, Value::Kind::null));
    }

    void OnAlias(const YAML::Mark& mark, YAML::anchor_t /*anchor*/) override { refuse_anchor(mark); }

    void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, const std::string& value) override {
        refuse_extras(mark, anchor, tag);
        if (!utf8::is_valid(value)) {
            fail(at(mark), path(), "is not UTF-8; allowed: Unicode text");
        }
        Value node = make(mark, Value::Kind::scalar);
        node.text = value;
        node.quoted = tag == "!";
        add(std::move(node));
    }

    void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, YAML::EmitterStyle::value) override {
        open(mark, tag, anchor, Value::Kind::list);
    }
    void OnSequenceEnd() override { close(); }

    void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, YAML::EmitterStyle::value) override {
        open(mark, tag, anchor, Value::Kind::mapping);
    }
    void OnMapEnd() override { close(); }

private:
    struct Frame {
        Value node;
        std::optional<Value> key;  // read, its value not yet
        std::set<std::string> keys;
    };

    [[nodiscard]] Location at(const YAML::Mark& mark) const {
        Location where = base_;
        if (where.line > 0 && mark.line >= 0) {
            where.line += mark.line;
        }
        return where;
    }

    [[nodiscard]] Value make(const YAML::Mark& mark, Value::Kind kind) const {
        Value node;
        node.kind = kind;
        node.where = at(mark);
        return node;
    }

    // Full key of the value that comes next.
    [[nodiscard]] std::string path() const {
        std::string result = path_;
        for (const Frame& frame : stack_) {
            if (frame.node.kind == Value::Kind::list) {
                result += fmt::format("[{}]", frame.node.children.size());
            } else if (frame.key) {
                result += (result.empty() ? "" : ".") + shorten(frame.key->text);
            }
        }
        return result;
    }

    [[noreturn]] void refuse_anchor(const YAML::Mark& mark) const {
        fail(at(mark), path(), "anchors and aliases (& and *) are not supported; allowed: the value itself, or quotes around a text");
    }

    void refuse_extras(const YAML::Mark& mark, YAML::anchor_t anchor, const std::string& tag) const {
        if (anchor != YAML::NullAnchor) {
            refuse_anchor(mark);
        }
        if (!tag.empty() && tag != "?" && tag != "!") {
            fail(at(mark), path(), "tags (!) are not supported; allowed: the value alone, or quotes around a text");
        }
    }

    void open(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, Value::Kind kind) {
        refuse_extras(mark, anchor, tag);
        if (stack_.size() >= kMaxDepth) {
            fail(at(mark), "", fmt::format("nested too deeply; allowed: {} levels", kMaxDepth));
        }
        stack_.push_back({make(mark, kind), std::nullopt, {}});
    }

    void close() {
        Value node = std::move(stack_.back().node);
        stack_.pop_back();
        add(std::move(node));
    }

    void add(Value node) {
        if (stack_.empty()) {
            root_ = std::move(node);
            return;
        }
        Frame& frame = stack_.back();
        if (frame.node.kind == Value::Kind::list) {
            frame.node.children.push_back(std::move(node));
        } else if (frame.key) {
            node.key = std::move(frame.key->text);
            node.where = frame.key->where;
            frame.key.reset();
            frame.node.children.push_back(std::move(node));
        } else {
            add_key(frame, std::move(node));
        }
    }

    void add_key(Frame& frame, Value key) const {
        if (key.text == "<<" && !key.quoted) {
            fail(key.where, path(), "merge keys (<<) are not supported; allowed: the keys themselves");
        }
        if (key.kind != Value::Kind::scalar) {
            fail(key.where, path(), fmt::format("{} is not a key; allowed: a word before the colon", spell(key)));
        }
        const bool fresh = frame.keys.insert(key.text).second;
        const Location where = key.where;
        const std::string text = key.text;
        frame.key = std::move(key);
        if (!fresh) {
            const Value* first = frame.node.find(text);
            const std::string line = first->where.line > 0 ? fmt::format(", first on line {}", first->where.line) : "";
            fail(where, path(), fmt::format("is given twice{}; allowed: once", line));
        }
    }

    Location base_;
    std::string path_;
    int documents_ = 0;
    std::vector<Frame> stack_;
    std::optional<Value> root_;
};

// Whether the line, counted from 0, has a tab among the blanks that it begins with.
bool is_indented_by_tab(const std::string& text, int line) {
    std::istringstream lines(text);
    std::string found;
    for (int k = 0; k <= line && std::getline(lines, found); ++k) {
        if (k == line) return found.substr(0, found.find_first_not_of(" \t")).find('\t') != std::string::npos;
    }
    return false;
}

// "a.b.c" in its parts; empty when one of them is.
std::vector<std::string> split_key(const std::string& key) {
    std::vector<std::string> parts;
    std::istringstream stream(key + ".");
    for (std::string part; std::getline(stream, part, '.');) {
        if (part.empty()) {
            return {};
        }
        parts.push_back(part);
    }
    return parts;
}

Value& child_of(Value& parent, const std::string& name, const Location& where) {
    const auto found = std::find_if(parent.children.begin(), parent.children.end(), [&](const Value& c) { return c.key == name; });
    if (found != parent.children.end()) {
        return *found;
    }
    Value child;
    child.key = name;
    child.where = where;
    return parent.children.emplace_back(std::move(child));
}

}  // namespace

const Value* Value::find(std::string_view name) const {
    if (kind != Kind::mapping) {
        return nullptr;
    }
    const auto found = std::find_if(children.begin(), children.end(), [&](const Value& child) { return child.key == name; });
    return found == children.end() ? nullptr : &*found;
}

void fail(const Location& where, std::string_view key, const std::string& what) {
    const std::string place = where.line > 0 ? fmt::format("{}:{}", *where.source, where.line) : *where.source;
    throw ConfigError(key.empty() ? fmt::format("{}: {}", place, what) : fmt::format("{}: {}: {}", place, key, what));
}

std::string spell(const Value& node) {
    switch (node.kind) {
        case Value::Kind::null:
            return "null";
        case Value::Kind::list:
            return "a list";
        case Value::Kind::mapping:
            return "a mapping";
        case Value::Kind::scalar:
            break;
    }
    return node.quoted ? fmt::format("\"{}\"", shorten(node.text)) : shorten(node.text);
}

Value parse(const std::string& text, const Location& where, const std::string& path) {
    if (text.size() > kMaxBytes) {
        fail({where.source, 0}, path, fmt::format("is too long; allowed: {} bytes", kMaxBytes));
    }
    TreeBuilder builder(where, path);
    std::istringstream stream(text);
    try {
        YAML::Parser parser(stream);
        while (parser.HandleNextDocument(builder)) {
        }
    } catch (const ConfigError&) {
        throw;
    } catch (const YAML::Exception& error) {
        Location place = where;
        place.line = where.line > 0 && error.mark.line >= 0 ? where.line + error.mark.line : 0;
        // YAML forbids it, and what yaml-cpp says of it depends on what follows.
        if (place.line > 0 && is_indented_by_tab(text, error.mark.line)) {
            fail(place, path, "a tab in the indentation; allowed: blanks");
        }
        fail(place, path, fmt::format("is not valid YAML: {}", error.msg));
    } catch (const std::exception& error) {
        // yaml-cpp lets a few of the standard library's through on malformed text.
        fail({where.source, 0}, path, fmt::format("is not valid YAML: {}", error.what()));
    }
    if (!builder.root()) {
        fail(where, path, "is empty; allowed: one YAML document");
    }
    return std::move(*builder.root());
}

void apply_override(Value& root, const std::string& assignment) {
    const Location where{std::make_shared<const std::string>(fmt::format("--set {}", shorten(assignment))), 0};
    if (!utf8::is_valid(assignment)) {
        fail(where, "", "is not UTF-8; allowed: Unicode text");
    }
    const std::size_t equals = assignment.find('=');
    const std::string key = assignment.substr(0, equals);
    const std::vector<std::string> parts = split_key(key);
    if (equals == std::string::npos || parts.empty() || parts.size() > kMaxDepth) {
        fail(where, "", "is not an assignment; allowed: KEY=VALUE with a key such as probing.epsilon");
    }
    Value* place = &root;
    std::string path;
    for (const std::string& part : parts) {
        if (place->kind == Value::Kind::null) {
            place->kind = Value::Kind::mapping;
        }
        if (place->kind != Value::Kind::mapping) {
            fail(where, path, fmt::format("{} is not a mapping; allowed: --set {}={{...}}, which replaces it", spell(*place), path));
        }
        path += (path.empty() ? "" : ".") + part;
        place = &child_of(*place, part, where);
    }
    Value value = parse(assignment.substr(equals + 1), where, key);
    value.key = parts.back();
    value.where = where;
    *place = std::move(value);
}

}  // namespace palpate::yaml
