#include "tools/view/internal/lettering.h"

#include <ft2build.h>
#include <utf8.h>
#include FT_FREETYPE_H

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <memory>
#include <stdexcept>

// tools/view/internal/font.S
extern "C" const unsigned char kPalpateFontBegin[];
extern "C" const unsigned char kPalpateFontEnd[];

namespace palpate {

namespace {

constexpr double kFixed = 64.0;  // FreeType's lengths are pixels / 64

void require(FT_Error error) {
    if (error != 0) throw std::logic_error("FreeType: the font that is built in cannot be read");
}

// The font, at one size.
class Font {
public:
    explicit Font(double size_px) {
        FT_Library library = nullptr;
        require(FT_Init_FreeType(&library));
        library_.reset(library);
        FT_Face face = nullptr;
        require(FT_New_Memory_Face(library, kPalpateFontBegin, kPalpateFontEnd - kPalpateFontBegin, 0, &face));
        face_.reset(face);
        constexpr FT_UInt kPointsPerInch = 72;  // a point is a pixel
        require(FT_Set_Char_Size(face, 0, std::max<FT_F26Dot6>(1, std::lround(size_px * kFixed)), kPointsPerInch, kPointsPerInch));
    }

    [[nodiscard]] FT_Face face() const { return face_.get(); }
    [[nodiscard]] int ascent_px() const {
        return static_cast<int>(std::ceil(static_cast<double>(face()->size->metrics.ascender) / kFixed));
    }
    [[nodiscard]] int height_px() const {
        return ascent_px() + static_cast<int>(std::ceil(-static_cast<double>(face()->size->metrics.descender) / kFixed));
    }
    // Its bitmap is in the face's slot until the next one.
    [[nodiscard]] const FT_GlyphSlotRec_& draw(char32_t letter) const {
        require(FT_Load_Char(face(), letter, FT_LOAD_RENDER | FT_LOAD_NO_HINTING));
        return *face()->glyph;
    }
    [[nodiscard]] double advance_px(char32_t letter) const {
        require(FT_Load_Char(face(), letter, FT_LOAD_NO_HINTING));
        return static_cast<double>(face()->glyph->linearHoriAdvance) / 65536.0;
    }

private:
    struct Done {
        void operator()(FT_Library library) const { FT_Done_FreeType(library); }
        void operator()(FT_Face face) const { FT_Done_Face(face); }
    };
    std::unique_ptr<FT_LibraryRec_, Done> library_;
    std::unique_ptr<FT_FaceRec_, Done> face_;
};

}  // namespace

Lettering letter(const std::string& text, double size_px) {
    std::string valid;
    utf8::replace_invalid(text.begin(), text.end(), std::back_inserter(valid), U' ');
    const std::u32string letters = utf8::utf8to32(valid);
    const Font font(size_px);
    double width = 0;
    for (const char32_t c : letters) width += font.advance_px(c);
    Lettering line{static_cast<int>(std::ceil(width)), font.height_px(), font.ascent_px(), {}};
    line.cover.resize(static_cast<std::size_t>(line.width_px) * static_cast<std::size_t>(line.height_px));
    double pen = 0;
    for (const char32_t c : letters) {
        const FT_GlyphSlotRec_& glyph = font.draw(c);
        for (int row = 0; row < static_cast<int>(glyph.bitmap.rows); ++row) {
            for (int column = 0; column < static_cast<int>(glyph.bitmap.width); ++column) {
                const int x = static_cast<int>(std::lround(pen)) + glyph.bitmap_left + column;
                const int y = line.ascent_px - glyph.bitmap_top + row;
                if (x < 0 || y < 0 || x >= line.width_px || y >= line.height_px) continue;
                float& cover =
                    line.cover[static_cast<std::size_t>(y) * static_cast<std::size_t>(line.width_px) + static_cast<std::size_t>(x)];
                cover = std::max(cover, static_cast<float>(glyph.bitmap.buffer[row * glyph.bitmap.pitch + column]) / 255.0F);
            }
        }
        pen += font.advance_px(c);
    }
    return line;
}

}  // namespace palpate
