#include "planner/random.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace palpate {

Segment random_chord(const Ball& ball, std::mt19937_64& random) {
    constexpr double kTurn = 2.0 * std::numbers::pi;
    const double z = 2.0 * uniform(random) - 1.0;
    const double longitude = kTurn * uniform(random);
    const double rho = std::sqrt(1.0 - z * z);
    const Vector direction(rho * std::cos(longitude), rho * std::sin(longitude), z);
    const Vector across = direction.unitOrthogonal();
    const double share = uniform(random);  // of the disc's area
    const double angle = kTurn * uniform(random);
    const Vector off = ball.radius * std::sqrt(share) * (std::cos(angle) * across + std::sin(angle) * direction.cross(across));
    const Vector half = ball.radius * std::sqrt(1.0 - share) * direction;
    return {ball.center + off - half, ball.center + off + half};
}

}  // namespace palpate
