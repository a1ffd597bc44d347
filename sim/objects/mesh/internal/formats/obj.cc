#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>

#include "sim/objects/mesh/internal/formats/formats.h"
#include "sim/objects/mesh/internal/formats/text_scanner.h"
#include "sim/objects/mesh/internal/message_text.h"

namespace palpate {
namespace {

class ObjReader {
public:
    explicit ObjReader(std::string_view bytes) : in_(bytes, {.comments = true, .continued = true}) {}

    PolygonSoup read() {
        for (std::string_view keyword = in_.word(); !keyword.empty(); keyword = in_.word()) {
            if (equal_words(keyword, "v")) read_point();
            if (equal_words(keyword, "f") || equal_words(keyword, "fo")) read_face();
            if (is_continued(keyword)) {
                in_.skip_line();
            } else {
                in_.skip_line_as_written();  // a name may end with a backslash
            }
        }
        if (farthest_ && farthest_->index >= soup_.points.size())
            farthest_->scanner.refuse(out_of_range(farthest_->index + std::int64_t{1}));
        return std::move(soup_);
    }

private:
    static bool is_continued(std::string_view keyword) {
        constexpr std::array<std::string_view, 7> kContinued{"v", "vn", "vt", "f", "fo", "l", "p"};
        return std::ranges::any_of(kContinued, [&](std::string_view k) { return equal_words(keyword, k); });
    }

    void read_point() {
        Point p;
        for (double& x : p) x = in_.coordinate(in_.word_on_line());
        soup_.points.push_back(p);
    }

    void read_face() {
        auto& polygon = soup_.polygons.emplace_back();
        for (std::string_view word = in_.word_on_line(); !word.empty(); word = in_.word_on_line()) polygon.push_back(corner(word));
        if (polygon.empty()) in_.refuse_word({}, "the index of a point");
    }

    // Of "7", "7/3", "7//5" or "7/3/5" the first counts: from 1, or back from the last point so far.
    std::uint32_t corner(std::string_view word) {
        constexpr std::string_view kExpected = "the index of a point";
        const std::string_view digits = word.substr(0, word.find('/'));
        if (digits.empty()) in_.refuse_word(word, kExpected);
        const std::int64_t index = in_.whole(digits, kExpected);
        const auto points = static_cast<std::int64_t>(soup_.points.size());
        if (index == 0 || index < -points || index > std::int64_t{UINT32_MAX}) in_.refuse(out_of_range(index));
        const auto from_zero = static_cast<std::uint32_t>(index > 0 ? index - 1 : points + index);
        // A point may follow the faces that name it, so whether it exists is known at the end.
        if (!farthest_ || from_zero > farthest_->index) farthest_ = Farthest{from_zero, in_};
        return from_zero;
    }

    [[nodiscard]] std::string out_of_range(std::int64_t index) const { return no_such_point(index, soup_.points.size(), 1); }

    struct Farthest {
        std::uint32_t index;
        TextScanner scanner;  // stands where it is named
    };

    TextScanner in_;
    PolygonSoup soup_;
    std::optional<Farthest> farthest_;
};

}  // namespace

PolygonSoup read_obj(std::string_view bytes) { return ObjReader(bytes).read(); }

}  // namespace palpate
