#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string>

#include "sim/objects/mesh/internal/formats/byte_reader.h"
#include "sim/objects/mesh/internal/formats/formats.h"
#include "sim/objects/mesh/internal/formats/text_scanner.h"
#include "sim/objects/mesh/internal/message_text.h"

namespace palpate {
namespace {

constexpr std::size_t kHeaderBytes = 80;
constexpr std::size_t kFirstTriangle = kHeaderBytes + sizeof(std::uint32_t);
constexpr std::size_t kTriangleBytes = 50;  // a normal, three corners of three floats, two bytes of whatever

void add_corner(PolygonSoup& soup, const Point& p) {
    soup.polygons.back().push_back(static_cast<std::uint32_t>(soup.points.size()));
    soup.points.push_back(p);
}

std::size_t announced_triangles(std::string_view bytes) {
    return ByteReader(bytes, kHeaderBytes, std::endian::little).take<std::uint32_t>("the number of triangles");
}

// The header of a binary file may begin with "solid" and its data may look like anything, but its size follows from the number of
// triangles; a text that happens to have such a number has it in characters, which make more triangles than any file holds.
bool is_text(std::string_view bytes) {
    if (bytes.size() >= kFirstTriangle && bytes.size() == kFirstTriangle + kTriangleBytes * announced_triangles(bytes)) return false;
    TextScanner in(bytes);
    const std::string_view first = in.word();
    if (equal_words(first, "facet")) return true;
    return equal_words(first, "solid") && bytes.substr(0, kFirstTriangle + kTriangleBytes).find('\0') == std::string_view::npos;
}

void expect(TextScanner& in, std::string_view keyword) {
    const std::string_view word = in.word();
    if (!equal_words(word, keyword)) in.refuse_word(word, fmt::format("'{}'", keyword));
}

// From after "facet" to "endfacet". The normal does not count: many programs write none, or nan.
void read_facet(TextScanner& in, PolygonSoup& soup) {
    std::string_view word = in.word();
    if (!equal_words(word, "normal")) in.refuse_word(word, "'normal'");
    do {
        word = in.word();
    } while (!word.empty() && !equal_words(word, "outer") && !equal_words(word, "vertex"));
    if (!equal_words(word, "outer")) in.refuse_word(word, "'outer loop'");
    expect(in, "loop");
    soup.polygons.emplace_back();
    for (word = in.word(); !equal_words(word, "endloop"); word = in.word()) {
        if (!equal_words(word, "vertex")) in.refuse_word(word, "'vertex' or 'endloop'");
        Point p;
        for (double& x : p) x = in.coordinate(in.word());
        add_corner(soup, p);
    }
    expect(in, "endfacet");
}

PolygonSoup read_text(std::string_view bytes) {
    TextScanner in(bytes);
    PolygonSoup soup;
    bool inside = true;  // a solid: after its end, whatever follows is read over up to the next one
    for (std::string_view word = in.word(); !word.empty(); word = in.word()) {
        if (equal_words(word, "facet")) {
            read_facet(in, soup);
        } else if (equal_words(word, "solid") || equal_words(word, "endsolid")) {
            inside = equal_words(word, "solid");
            in.skip_line();  // a name, which may hold any word
        } else if (equal_words(word, "color") || !inside) {
            in.skip_line();
        } else {
            in.refuse_word(word, "'facet' or 'endsolid'");
        }
    }
    return soup;
}

PolygonSoup read_binary(std::string_view bytes) {
    if (bytes.size() < kFirstTriangle) {
        throw ObjectError(
            fmt::format("neither text, which begins with 'solid', nor binary, which has a header of {} bytes: the file ends after {}",
                        kFirstTriangle, bytes.size()));
    }
    const std::size_t count = announced_triangles(bytes);
    const std::size_t held = (bytes.size() - kFirstTriangle) / kTriangleBytes;
    if (held < count) {
        throw ObjectError(
            fmt::format("byte {}: the file ends in triangle {} of {}; it is cut off, or not an STL file: export the mesh again",
                        bytes.size(), held + 1, count));
    }
    // Fewer bytes than a triangle has, or zeros, are no triangle that would be lost.
    const std::string_view rest = bytes.substr(kFirstTriangle + kTriangleBytes * count);
    if (rest.size() >= kTriangleBytes && rest.find_first_not_of('\0') != std::string_view::npos) {
        throw ObjectError(fmt::format("{} bytes follow the {} that the header announces; export the mesh again, as one solid", rest.size(),
                                      counted(count, "triangle", "triangles")));
    }
    ByteReader in(bytes, kFirstTriangle, std::endian::little);
    PolygonSoup soup;
    for (std::size_t i = 0; i < count; ++i) {
        soup.polygons.emplace_back();
        for (int j = 0; j < 3; ++j) (void)in.take<float>("a normal");
        for (int corner = 0; corner < 3; ++corner) {
            Point p;
            for (double& x : p) {
                x = in.take<float>("a coordinate");
                if (!(std::abs(x) <= kLargestCoordinate)) in.refuse(fmt::format("{:f} where a coordinate was expected", x));
            }
            add_corner(soup, p);
        }
        (void)in.take<std::uint16_t>("the end of a triangle");
    }
    return soup;
}

}  // namespace

PolygonSoup read_stl(std::string_view bytes) { return is_text(bytes) ? read_text(bytes) : read_binary(bytes); }

}  // namespace palpate
