// Linear light, and how it becomes bytes.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace palpate {

using Colour = Eigen::Array3f;  // linear light

// Keeps bright places from burning out.
[[nodiscard]] Colour soften(const Colour& light);

[[nodiscard]] std::uint8_t to_srgb(float linear);
[[nodiscard]] Colour from_srgb(const std::array<std::uint8_t, 3>& srgb);

}  // namespace palpate
