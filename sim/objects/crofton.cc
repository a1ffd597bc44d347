#include "sim/objects/crofton.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "sim/objects/errors.h"

namespace palpate {
namespace {

// Uniformly distributed over all lines that meet the ball; as the chord in it.
Segment random_chord(const Point& center, double radius, std::mt19937_64& random) {
    constexpr double kTurn = 2.0 * std::numbers::pi;
    const double z = 2.0 * uniform(random) - 1.0;
    const double longitude = kTurn * uniform(random);
    const double rho = std::sqrt(1.0 - z * z);
    const Vector direction(rho * std::cos(longitude), rho * std::sin(longitude), z);
    const Vector across = direction.unitOrthogonal();
    const double share = uniform(random);  // of the disc's area
    const double angle = kTurn * uniform(random);
    const Vector off = radius * std::sqrt(share) * (std::cos(angle) * across + std::sin(angle) * direction.cross(across));
    const Vector half = radius * std::sqrt(1.0 - share) * direction;
    return {center + off - half, center + off + half};
}

}  // namespace

double uniform(std::mt19937_64& random) {
    constexpr double kUnit = 0x1p-53;
    return static_cast<double>(random() >> 11U) * kUnit;
}

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
        const std::vector<Point> points = object.crossings(random_chord(box.center(), radius, random));
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
