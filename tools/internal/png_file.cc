#include "tools/internal/png_file.h"

#include <png.h>

#include "tools/session_files.h"

namespace palpate {

void write_png(const std::filesystem::path& png, const Picture& picture) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.format = PNG_FORMAT_RGB;
    image.flags = PNG_IMAGE_FLAG_FAST;  // of these pictures it makes smaller files, too
    image.width = static_cast<png_uint_32>(picture.width_px);
    image.height = static_cast<png_uint_32>(picture.height_px);
    if (png_image_write_to_file(&image, png.c_str(), 0, picture.rgb.data(), 0, nullptr) == 0) {
        throw OutputError(png.string() + ": cannot be written: " + image.message + "; is the disk full, or the folder read-only?");
    }
}

}  // namespace palpate
