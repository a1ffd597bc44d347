#include "tools/view/internal/colour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace palpate {

Colour soften(const Colour& light) { return 1.0F - (-light).exp(); }

std::uint8_t to_srgb(float linear) {
    // A table, because a picture would need millions of powers.
    constexpr int kSteps = 8192;
    static const auto kBytes = [] {
        std::array<std::uint8_t, kSteps + 1> bytes{};
        for (int k = 0; k <= kSteps; ++k) {
            const double c = 1.0 * k / kSteps;
            const double encoded = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1.0 / 2.4) - 0.055;
            bytes[static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(std::lround(255.0 * encoded));
        }
        return bytes;
    }();
    return kBytes[static_cast<std::size_t>(std::clamp(linear, 0.0F, 1.0F) * kSteps + 0.5F)];
}

Colour from_srgb(const std::array<std::uint8_t, 3>& srgb) {
    Colour colour;
    for (std::size_t k = 0; k < srgb.size(); ++k) {
        const double encoded = srgb.at(k) / 255.0;
        const double linear = encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
        colour[static_cast<Eigen::Index>(k)] = static_cast<float>(linear);
    }
    return colour;
}

}  // namespace palpate
