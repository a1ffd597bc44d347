#include "tools/view/internal/lights.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace palpate {

namespace {

// Colours and light were chosen by eye.
constexpr int kSky = 48;                    // lights
const Colour kBounce{0.26F, 0.25F, 0.25F};  // what a bright floor sends back up

// Sends light from a disc of directions around one, by the golden angle.
void add_lamp(std::vector<Light>& lights, const Vector& direction, double spread, int count, const Colour& intensity) {
    const Vector side = direction.unitOrthogonal();
    const Vector other = direction.normalized().cross(side);
    for (int i = 0; i < count; ++i) {
        const double r = spread * std::sqrt((i + 0.5) / count);
        const double angle = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
        lights.push_back({(direction.normalized() + r * std::cos(angle) * side + r * std::sin(angle) * other).normalized(),
                          intensity / static_cast<float>(count)});
    }
}

}  // namespace

std::vector<Light> studio(const Camera& camera, const Vector& up) {
    std::vector<Light> lights;
    const auto from = [&](double right, double above, double front) {
        return Vector(right * camera.right() + above * camera.up() + front * camera.toward_viewer());
    };
    add_lamp(lights, from(-0.75, 1.0, 0.75), 0.22, 28, Colour(2.30F, 2.16F, 1.98F));  // key
    add_lamp(lights, from(1.2, 0.25, 0.6), 0.35, 8, Colour(0.34F, 0.39F, 0.46F));     // fill
    // The sky: directions evenly spread over the upper half.
    const Vector side = up.unitOrthogonal();
    const Vector other = up.cross(side);
    for (int i = 0; i < kSky; ++i) {
        const double height = (i + 0.5) / kSky;
        const double angle = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
        const double r = std::sqrt(1.0 - height * height);
        lights.push_back({height * up + r * std::cos(angle) * side + r * std::sin(angle) * other, Colour(0.98F, 1.04F, 1.14F) / kSky});
    }
    return lights;
}

Colour bounce(const Vector& normal, const Vector& up) { return kBounce * static_cast<float>(0.5 - 0.5 * normal.dot(up)); }

}  // namespace palpate
