#include "devices/calibration/lobing_map.h"

#include <Eigen/Geometry>
#include <cmath>

namespace palpate {
namespace {

// The direction of the half that a stylus reaches which is nearest to `normal`.
Vector reachable(const Vector& normal, const Vector& axis) {
    const double height = normal.dot(axis);
    if (height >= 0) return normal;
    const Vector flat = normal - height * axis;
    // Straight along the axis all of the equator is as near.
    constexpr double kStraight = 1e-6;
    return flat.norm() > kStraight ? flat.normalized() : axis.unitOrthogonal();
}

}  // namespace

std::array<double, LobingMap::kCoefficients> lobing_harmonics(const Vector& unit) {
    const double x = unit.x();
    const double y = unit.y();
    const double z = unit.z();
    const double five = 5 * z * z - 1;
    return {
        std::sqrt(15.0) * x * y,
        std::sqrt(15.0) * y * z,
        std::sqrt(5.0) / 2 * (3 * z * z - 1),
        std::sqrt(15.0) * x * z,
        std::sqrt(15.0) / 2 * (x * x - y * y),
        std::sqrt(35.0 / 8) * y * (3 * x * x - y * y),
        std::sqrt(105.0) * x * y * z,
        std::sqrt(21.0 / 8) * y * five,
        std::sqrt(7.0) / 2 * z * (5 * z * z - 3),
        std::sqrt(21.0 / 8) * x * five,
        std::sqrt(105.0) / 2 * z * (x * x - y * y),
        std::sqrt(35.0 / 8) * x * (x * x - 3 * y * y),
    };
}

double LobingMap::pretravel(const Vector& normal) const {
    const std::array<double, kCoefficients> harmonics = lobing_harmonics(reachable(normal, axis));
    double sum = 0;
    for (std::size_t k = 0; k < kCoefficients; ++k) sum += coefficients_mm[k] * harmonics[k];
    return sum;
}

Point LobingMap::corrected(const Point& touched, const Vector& normal) const { return touched - pretravel(normal) * normal; }

}  // namespace palpate
