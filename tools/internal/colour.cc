#include "tools/internal/colour.h"

#include <algorithm>
#include <cmath>

namespace palpate {

Colour soften(const Colour& light) { return 1.0F - (-light).exp(); }

std::uint8_t to_srgb(float linear) {
    const float c = std::clamp(linear, 0.0F, 1.0F);
    const float encoded = c <= 0.0031308F ? 12.92F * c : 1.055F * std::pow(c, 1.0F / 2.4F) - 0.055F;
    return static_cast<std::uint8_t>(std::lround(255.0F * encoded));
}

}  // namespace palpate
