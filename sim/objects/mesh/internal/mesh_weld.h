// Which corners of faces are the same point.
#pragma once

#include <cstddef>

#include "sim/objects/mesh/internal/polygon_soup.h"

namespace palpate {

// Corners at exactly the same place become one.
void join_equal_points(PolygonSoup& soup);

struct Weld {
    std::size_t corners = 0;  // that were moved to another
    double distance = 0.0;    // in the file's unit: the longest way of one
};

// Joins ends of open edges that almost coincide.
//
// The same corner, computed twice by a program, differs by 1e-16 to 1e-14 of the mesh's size in double precision; written in single
// precision by up to 2^-23 sqrt(3) = 2e-7, written with six digits by up to 1e-5 sqrt(3) of the largest coordinate, which is some third of
// the size where the origin is in the middle: 6e-6. Features of 1e-4 are to stay. Of a mesh that lies so far from the origin that its
// coordinates are rounded more coarsely than that, parts do not exist any more; it is not guessed at.
//
// So that nothing is joined that needs not be, the reach grows by factors of two, and only as long as edges are open; only their ends are
// joined, each to the nearest, and never two corners of one face. The point with the lowest number stays where it is.
//
// A crack, where the same corner stands twice, is narrow beside the edges along it; the edges around a hole are as short as the hole is
// wide. So ends are joined only if they are closer than half the shortest open edge there. A hole narrower than that cannot be told from
// a crack, and is closed like one.
inline constexpr double kWeldReach = 1e-5;  // of the diagonal of the mesh's bounds
inline constexpr double kWeldShare = 0.5;   // of the shortest open edge at either end
Weld weld_open_edges(PolygonSoup& soup);

}  // namespace palpate
