#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "sim/objects/mesh/internal/formats/byte_reader.h"
#include "sim/objects/mesh/internal/formats/formats.h"
#include "sim/objects/mesh/internal/formats/text_scanner.h"
#include "sim/objects/mesh/internal/message_text.h"

namespace palpate {
namespace {

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct TypeName {
    std::string_view name;
    Type type;
};
constexpr std::array kTypeNames{TypeName{"char", Type::int8},      TypeName{"uchar", Type::uint8},    TypeName{"short", Type::int16},
                                TypeName{"ushort", Type::uint16},  TypeName{"int", Type::int32},      TypeName{"uint", Type::uint32},
                                TypeName{"float", Type::float32},  TypeName{"double", Type::float64}, TypeName{"int8", Type::int8},
                                TypeName{"uint8", Type::uint8},    TypeName{"int16", Type::int16},    TypeName{"uint16", Type::uint16},
                                TypeName{"int32", Type::int32},    TypeName{"uint32", Type::uint32},  TypeName{"float32", Type::float32},
                                TypeName{"float64", Type::float64}};

struct Property {
    std::string name;
    Type type = Type::float32;         // of the value, or of the items of a list
    std::optional<Type> count_type{};  // of the length of a list
};

struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::vector<Property> properties;
};

struct PlyHeader {
    std::optional<std::endian> binary;  // nothing: text
    std::vector<Element> elements;
    std::size_t size = 0;  // bytes
};

Type read_type(TextScanner& in) {
    const std::string_view word = in.word_on_line();
    const auto* found = std::ranges::find_if(kTypeNames, [&](const TypeName& t) { return equal_words(word, t.name); });
    if (found == kTypeNames.end()) in.refuse_word(word, "a type of numbers such as 'float' or 'int'");
    return found->type;
}

std::string read_name(TextScanner& in) {
    const std::string_view word = in.word_on_line();
    if (word.empty()) in.refuse_word(word, "a name");
    return lower_case(word);
}

std::optional<std::endian> read_encoding(TextScanner& in) {
    const std::string_view word = in.word_on_line();
    if (equal_words(word, "ascii")) return std::nullopt;
    if (equal_words(word, "binary_little_endian")) return std::endian::little;
    if (equal_words(word, "binary_big_endian")) return std::endian::big;
    in.refuse_word(word, "'ascii', 'binary_little_endian' or 'binary_big_endian'");
}

Element read_element(TextScanner& in) {
    Element element{read_name(in), 0, {}};
    element.count = in.count(in.word_on_line(), "how many there are");
    return element;
}

Property read_property(TextScanner& in) {
    Property property;
    TextScanner ahead = in;
    if (equal_words(ahead.word_on_line(), "list")) {
        in = ahead;
        property.count_type = read_type(in);
    }
    property.type = read_type(in);
    property.name = read_name(in);
    return property;
}

// Where data begins: behind the end of the line of end_header. Only if the file's lines end with CR alone, an LF there is data.
std::size_t end_of_header(std::string_view bytes, std::size_t offset) {
    const std::size_t first = bytes.find_first_of("\r\n");
    const bool only_returns = bytes[first] == '\r' && bytes[first + 1] != '\n';
    offset = std::min(bytes.find_first_of("\r\n", offset), bytes.size() - 1) + 1;
    if (!only_returns && bytes[offset - 1] == '\r' && offset < bytes.size() && bytes[offset] == '\n') ++offset;
    return offset;
}

PlyHeader read_header(std::string_view bytes) {
    TextScanner in(bytes);
    std::string_view word = in.word();
    if (!equal_words(word, "ply")) in.refuse_word(word, "'ply'");
    in.skip_line();
    PlyHeader header;
    bool has_format = false;
    for (word = in.word(); !equal_words(word, "end_header"); word = in.word()) {
        if (equal_words(word, "format")) {
            header.binary = read_encoding(in);
            has_format = true;
        } else if (equal_words(word, "element")) {
            header.elements.push_back(read_element(in));
        } else if (equal_words(word, "property")) {
            if (header.elements.empty()) in.refuse_word(word, "'element'");
            header.elements.back().properties.push_back(read_property(in));
        } else if (!equal_words(word, "comment") && !equal_words(word, "obj_info")) {
            in.refuse_word(word, "'element', 'property' or 'end_header'");
        }
        in.skip_line();
    }
    if (!has_format) in.refuse_word(word, "'format'");
    header.size = end_of_header(bytes, in.offset());
    return header;
}

// The values of the elements, one after another, from either encoding.
class TextValues {
public:
    // If there are as many lines as `rows`, each row has its own.
    TextValues(TextScanner in, std::uint64_t rows) : in_(in), lines_(count_lines(in) == rows) {}
    void begin_row() { first_ = true; }
    void end_row() {
        if (!lines_) return;
        if (const std::string_view word = in_.word_on_line(); !word.empty()) in_.refuse_word(word, "the end of the line");
    }
    void end() {
        const std::string_view word = in_.word();
        if (!word.empty()) in_.refuse(fmt::format("{} follows all that the header announces", quoted_word(word)));
    }
    double coordinate(Type /*type*/) { return in_.coordinate(next()); }
    std::int64_t whole(Type /*type*/, std::string_view expected) { return in_.whole(next(), expected); }
    void skip(Type /*type*/) {
        if (next().empty()) in_.refuse_word({}, "a number");
    }
    [[noreturn]] void refuse(const std::string& what) const { in_.refuse(what); }

private:
    std::string_view next() {
        const bool anywhere = first_ || !lines_;
        first_ = false;
        return anywhere ? in_.word() : in_.word_on_line();
    }

    TextScanner in_;
    bool lines_;
    bool first_ = true;  // of a row
};

class BinaryValues {
public:
    explicit BinaryValues(ByteReader in) : in_(in) {}
    static void begin_row() {}
    static void end_row() {}
    void end() const {
        constexpr std::string_view kPadding("\0 \t\r\n\x1A", 6);
        if (in_.rest().find_first_not_of(kPadding) == std::string_view::npos) return;
        throw ObjectError(fmt::format("{} all that the header announces; export the mesh again",
                                      counted(in_.rest().size(), "byte follows", "bytes follow")));
    }
    double coordinate(Type type) {
        constexpr std::string_view kExpected = "a coordinate";
        const double value = take(type, kExpected);
        if (!(std::abs(value) <= kLargestCoordinate)) refuse_value(value, kExpected);
        return value;
    }
    std::int64_t whole(Type type, std::string_view expected) {
        const double value = take(type, expected);
        constexpr double kLargest = std::numeric_limits<std::uint32_t>::max();
        if (!(std::abs(value) <= kLargest) || value != std::floor(value)) refuse_value(value, expected);
        return static_cast<std::int64_t>(value);
    }
    void skip(Type type) { (void)take(type, "a number"); }
    [[noreturn]] void refuse(const std::string& what) const { in_.refuse(what); }

private:
    double take(Type type, std::string_view expected) {
        switch (type) {
            case Type::int8:
                return in_.take<std::int8_t>(expected);
            case Type::uint8:
                return in_.take<std::uint8_t>(expected);
            case Type::int16:
                return in_.take<std::int16_t>(expected);
            case Type::uint16:
                return in_.take<std::uint16_t>(expected);
            case Type::int32:
                return in_.take<std::int32_t>(expected);
            case Type::uint32:
                return in_.take<std::uint32_t>(expected);
            case Type::float32:
                return in_.take<float>(expected);
            case Type::float64:
                break;
        }
        return in_.take<double>(expected);
    }
    [[noreturn]] void refuse_value(double value, std::string_view expected) const {
        in_.refuse(fmt::format("{:f} where {} was expected", value, expected));
    }

    ByteReader in_;
};

template <class Values>
class BodyReader {
public:
    explicit BodyReader(Values values) : in_(std::move(values)) {}

    PolygonSoup read(const std::vector<Element>& elements) {
        const auto vertices = std::ranges::find(elements, "vertex", &Element::name);
        if (vertices != elements.end()) points_ = vertices->count;
        for (const Element& element : elements) {
            if (element.properties.empty()) continue;  // says nothing, however often
            for (std::uint64_t i = 0; i < element.count; ++i) {
                in_.begin_row();
                if (element.name == "vertex") soup_.points.emplace_back(Point::Zero());
                if (element.name == "face") soup_.polygons.emplace_back();
                for (const Property& property : element.properties) read_property(element, property);
                in_.end_row();
            }
        }
        in_.end();
        return std::move(soup_);
    }

private:
    void read_property(const Element& element, const Property& property) {
        constexpr std::array<std::string_view, 3> kAxes{"x", "y", "z"};
        const auto axis = static_cast<std::size_t>(std::ranges::find(kAxes, property.name) - kAxes.begin());
        if (property.count_type) {
            const bool corners = element.name == "face" && (property.name == "vertex_indices" || property.name == "vertex_index");
            read_list(property, corners);
        } else if (element.name == "vertex" && axis < kAxes.size()) {
            soup_.points.back()[static_cast<Eigen::Index>(axis)] = in_.coordinate(property.type);
        } else {
            in_.skip(property.type);
        }
    }

    void read_list(const Property& property, bool corners) {
        const std::int64_t count = in_.whole(*property.count_type, "the length of a list");
        if (count < 0) in_.refuse(fmt::format("{} where the length of a list was expected", count));
        for (std::int64_t i = 0; i < count; ++i) {
            if (corners) {
                soup_.polygons.back().push_back(corner(property.type));
            } else {
                in_.skip(property.type);
            }
        }
    }

    std::uint32_t corner(Type type) {
        const std::int64_t index = in_.whole(type, "the index of a point");
        if (index < 0 || static_cast<std::uint64_t>(index) >= points_) in_.refuse(no_such_point(index, points_, 0));
        return static_cast<std::uint32_t>(index);
    }

    Values in_;
    PolygonSoup soup_;
    std::uint64_t points_ = 0;
};

void check_elements(const std::vector<Element>& elements) {
    const auto count_of = [&](std::string_view name) {
        return std::ranges::count_if(elements, [&](const Element& e) { return e.name == name && e.count > 0; });
    };
    if (count_of("tristrips") > 0) {
        throw ObjectError("holds triangle strips (element tristrips), which cannot be read; export the mesh with faces");
    }
    if (count_of("vertex") > 1 || count_of("face") > 1) throw ObjectError("the header names an element twice: vertex or face");
    for (const Element& element : elements) {
        const auto has = [&](std::string_view name, bool list) {
            return std::ranges::any_of(element.properties,
                                       [&](const Property& p) { return p.name == name && p.count_type.has_value() == list; });
        };
        if (element.name == "vertex" && !(has("x", false) && has("y", false) && has("z", false))) {
            throw ObjectError("the header names no properties x, y and z of element vertex");
        }
        if (element.name == "face" && has("vertex_indices", true) == has("vertex_index", true)) {
            throw ObjectError("the header names no list vertex_indices (or vertex_index) of element face, or both");
        }
    }
}

}  // namespace

PolygonSoup read_ply(std::string_view bytes) {
    const PlyHeader header = read_header(bytes);
    check_elements(header.elements);
    if (header.binary) return BodyReader(BinaryValues(ByteReader(bytes, header.size, *header.binary))).read(header.elements);
    TextScanner text(bytes);
    while (text.offset() < header.size) text.skip_line();
    std::uint64_t rows = 0;
    for (const Element& element : header.elements) rows += element.properties.empty() ? 0 : element.count;
    return BodyReader(TextValues(text, rows)).read(header.elements);
}

}  // namespace palpate
