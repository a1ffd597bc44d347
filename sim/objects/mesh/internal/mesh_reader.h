// Mesh files to faces, without judging whether they bound a solid.
#pragma once

#include <filesystem>

#include "sim/objects/mesh/internal/polygon_soup.h"

namespace palpate {

// Reads OFF, OBJ, STL or PLY, by extension. Throws ObjectError, naming the file, if it is missing, empty, of an unknown format or holds no
// faces; and where in it (line or byte) something else stands than was expected.
[[nodiscard]] PolygonSoup read_mesh(const std::filesystem::path& file);

}  // namespace palpate
