// Mesh formats, each from the bytes of a file. What is read is what the file says: equal points stay apart, faces may have any number
// of corners. Indices are in range.
//
// All throw ObjectError that says where (line of a text, byte of binary data), what was found there and what was expected. None
// believes a count in a header: memory grows with what is read.
#pragma once

#include <string_view>

#include "sim/objects/mesh/internal/polygon_soup.h"

namespace palpate {

// Geomview's text: OFF, with the prefixes ST, C and N, whose numbers are read over. Tokens may be broken over lines; the count of edges
// may be missing.
[[nodiscard]] PolygonSoup read_off(std::string_view bytes);
// Wavefront's text: v and f count, everything else is read over.
[[nodiscard]] PolygonSoup read_obj(std::string_view bytes);
// Text or binary, whichever it is: `solid` begins many a binary file, too.
[[nodiscard]] PolygonSoup read_stl(std::string_view bytes);
// Text, little and big endian, all types of numbers; elements and properties beside points and faces are read over.
[[nodiscard]] PolygonSoup read_ply(std::string_view bytes);

}  // namespace palpate
