// Known places that show whether part and machine are where they were: a shift along a surface is not seen by a touch of it, so it takes
// three whose normals are independent (devices/FACTS.md, "Safety floor").
#pragma once

#include <optional>
#include <vector>

#include "devices/session/journal.h"
#include "devices/session/visited_ways.h"

namespace palpate {

// A contact of the journal that can be made again.
struct DatumPlace {
    std::uint64_t line = 0;  // of the journal
    Point from = Point::Zero();
    Point touched = Point::Zero();
    Vector inwards = Vector::Zero();  // unit: the way of the touch
    Vector normal = Vector::Zero();   // unit, of S there, as the touches around show it; zero if they do not
};

// Up to three, near to `from` over ways that were gone, in the order in which they are best visited. Those whose normals are known and
// independent come first.
// Only contacts among the first `moves` of the journal are believed.
[[nodiscard]] std::vector<DatumPlace> choose_datum_places(const Journal& journal, const VisitedWays& visited_ways, const Point& from,
                                                          std::size_t moves);

// In how many independent directions, 0 to 3, those places would show a shift of 5 touch errors, by an offset of more than 2 at one of them
// at least; 3: in every direction. Exact touches taken for granted.
[[nodiscard]] int independent_directions(const std::vector<DatumPlace>& places);

}  // namespace palpate
