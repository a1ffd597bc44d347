#include "sim/objects/crofton.h"

#include <numbers>

#include "planner/random.h"
#include "sim/objects/errors.h"

namespace palpate {
SurfaceSample sample_surface(const HiddenObject& object, std::size_t count, std::mt19937_64& random) {
    // A needle of a length of 1000 diameters is met by one line in some 600.
    constexpr std::size_t kMostMisses = 1'000'000;  // in a row
    constexpr double kSlack = 1.0 + 1e-6;           // keeps the chords' ends off S
    const Box& box = object.bounds();
    const double radius = 0.5 * kSlack * box.diagonal();
    SurfaceSample sample;
    std::size_t lines = 0;
    std::size_t misses = 0;
    while (sample.points.size() < count) {
        const std::vector<Point> points = object.crossings(random_chord(Ball{box.center(), radius}, random));
        sample.points.insert(sample.points.end(), points.begin(), points.end());
        ++lines;
        misses = points.empty() ? misses + 1 : 0;
        if (misses > kMostMisses)
            throw ObjectError("object: a million lines in a row miss it: it is too thin for its extent, or too large, to be reckoned with");
    }
    if (lines == 0) return sample;
    const double per_line = static_cast<double>(sample.points.size()) / static_cast<double>(lines);
    sample.area = per_line * 2.0 * std::numbers::pi * radius * radius;
    return sample;
}

}  // namespace palpate
