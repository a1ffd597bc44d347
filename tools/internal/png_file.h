// A picture as a PNG file.
#pragma once

#include <filesystem>

#include "tools/picture.h"

namespace palpate {

// Replaces the file. Throws OutputError when it cannot be written.
void write_png(const std::filesystem::path& png, const Picture& picture);

}  // namespace palpate
