#include "tools/internal/png_file.h"

#include <png.h>

#include <stdexcept>

namespace palpate {

void write_png(const std::filesystem::path& png, const Picture& picture) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.format = PNG_FORMAT_RGB;
    image.width = static_cast<png_uint_32>(picture.width_px);
    image.height = static_cast<png_uint_32>(picture.height_px);
    if (png_image_write_to_file(&image, png.c_str(), 0, picture.rgb.data(), 0, nullptr) == 0) {
        throw std::runtime_error("cannot write the picture " + png.string() + ": " + image.message);
    }
}

}  // namespace palpate
