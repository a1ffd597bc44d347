// A picture as the bytes of a PNG file.
#pragma once

#include <string>

#include "tools/view/picture.h"

namespace palpate {

[[nodiscard]] std::string to_png(const Picture& picture);

}  // namespace palpate
