// Linear light, and how it becomes bytes.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace palpate {

using Colour = Eigen::Array3f;  // linear light

// Keeps bright places from burning out.
[[nodiscard]] Colour soften(const Colour& light);

[[nodiscard]] std::uint8_t to_srgb(float linear);

}  // namespace palpate
