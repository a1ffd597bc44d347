#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <string>

#include "sim/objects/mesh/internal/formats/formats.h"
#include "sim/objects/mesh/internal/formats/text_scanner.h"
#include "sim/objects/mesh/internal/message_text.h"

namespace palpate {
namespace {

struct OffHeader {
    std::size_t points = 0;
    std::size_t faces = 0;
    std::size_t extras = 0;  // numbers of every point besides its coordinates
};

// Numbers besides the coordinates that a keyword such as COFF or STNOFF announces; nothing if it is none.
std::optional<std::size_t> extras_of(std::string_view keyword) {
    constexpr std::size_t kTextureNumbers = 2;
    constexpr std::size_t kColourNumbers = 4;
    constexpr std::size_t kNormalNumbers = 3;
    struct Prefix {
        std::string_view name;
        std::size_t numbers;
        bool taken = false;
    };
    std::array prefixes{Prefix{"st", kTextureNumbers}, Prefix{"c", kColourNumbers}, Prefix{"n", kNormalNumbers}};
    std::size_t extras = 0;
    const auto begins_keyword = [&](const Prefix& p) { return !p.taken && equal_words(keyword.substr(0, p.name.size()), p.name); };
    for (auto p = std::ranges::find_if(prefixes, begins_keyword); p != prefixes.end();  // in any order, each once
         p = std::ranges::find_if(prefixes, begins_keyword)) {
        p->taken = true;
        keyword.remove_prefix(p->name.size());
        extras += p->numbers;
    }
    if (!equal_words(keyword, "off")) return std::nullopt;
    return extras;
}

OffHeader read_header(TextScanner& in) {
    OffHeader header;
    std::string_view word = in.word();
    if (word.starts_with("nOFF") || (word.starts_with("4") && extras_of(word.substr(1)))) {
        in.refuse(fmt::format("{} has points that are not of three coordinates; export the mesh as OFF", quoted_word(word)));
    }
    if (const auto extras = extras_of(word)) {
        header.extras = *extras;
        word = in.word();
        if (equal_words(word, "binary")) in.refuse("binary OFF cannot be read; export the mesh as text, or in another format");
    } else if (word.empty() || word.find_first_not_of("0123456789") != std::string_view::npos) {  // the keyword may be missing
        in.refuse_word(word, "'OFF'");
    }
    header.points = in.count(word, "the number of points");
    const std::size_t line = in.line();
    header.faces = in.count(in.word(), "the number of faces");
    // The count of edges may be missing, which only the end of the line shows. Words that are broken over lines are complete.
    if (in.line() != line || !in.at_line_end()) (void)in.whole(in.word(), "the number of edges");
    return header;
}

// Does the line of each point hold coordinates, and that of each face the corners that it announces?
bool lines_are_complete(TextScanner in, const OffHeader& header) {
    for (std::size_t i = 0; i < header.points + header.faces; ++i) {
        const std::string_view first = in.word();
        std::size_t wanted = 2;  // words after the first
        if (i >= header.points && std::from_chars(first.data(), first.data() + first.size(), wanted).ec != std::errc()) return false;
        for (std::size_t j = 0; j < wanted; ++j) {
            if (in.word_on_line().empty()) return false;
        }
        in.skip_line();
    }
    return true;
}

// Has every point and face a line of its own? Then what follows on it, such as colours, need not be told, and nothing may be missing.
bool has_a_line_for_each(const TextScanner& in, const OffHeader& header) {
    const std::size_t lines = count_lines(in);
    const std::size_t wanted = header.points + header.faces;
    return lines == wanted || (lines > wanted && lines_are_complete(in, header));
}

std::uint32_t read_corner(const TextScanner& in, std::string_view word, std::size_t points) {
    const std::int64_t index = in.whole(word, "the index of a point");
    if (index < 0 || static_cast<std::size_t>(index) >= points) in.refuse(no_such_point(index, points, 0));
    return static_cast<std::uint32_t>(index);
}

}  // namespace

PolygonSoup read_off(std::string_view bytes) {
    TextScanner in(bytes, {.comments = true});
    const OffHeader header = read_header(in);
    const bool lines = has_a_line_for_each(in, header);
    const auto next = [&] { return lines ? in.word_on_line() : in.word(); };
    PolygonSoup soup;
    for (std::size_t i = 0; i < header.points; ++i) {
        Point p;
        p.x() = in.coordinate(in.word());
        p.y() = in.coordinate(next());
        p.z() = in.coordinate(next());
        soup.points.push_back(p);
        if (lines) {
            in.skip_line();
        } else {
            for (std::size_t j = 0; j < header.extras; ++j) (void)in.word();
        }
    }
    for (std::size_t i = 0; i < header.faces; ++i) {
        auto& polygon = soup.polygons.emplace_back();
        const std::size_t corners = in.count(in.word(), "the number of corners of a face");
        for (std::size_t j = 0; j < corners; ++j) polygon.push_back(read_corner(in, next(), header.points));
        if (lines) in.skip_line();
    }
    if (const std::string_view word = in.word(); !word.empty()) {
        in.refuse(fmt::format("{} follows the {} that the header announces", quoted_word(word), counted(header.faces, "face", "faces")));
    }
    return soup;
}

}  // namespace palpate
