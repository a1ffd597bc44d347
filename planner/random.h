// What is drawn by chance; std's distributions differ between libraries, these do not.
#pragma once

#include <random>

#include "planner/geometry.h"

namespace palpate {

// In [0, 1), from the top 53 bits.
[[nodiscard]] inline double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11U) * 0x1p-53; }

// Uniformly distributed over all lines that meet the ball; as the chord in it.
[[nodiscard]] Segment random_chord(const Ball& ball, std::mt19937_64& random);

}  // namespace palpate
