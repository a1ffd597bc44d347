#include "devices/kinematics.h"

#include <cmath>

namespace palpate {

Seconds move_duration(const Kinematics& k, double length_mm, double feed_mm_per_s) {
    const double ramps = feed_mm_per_s * feed_mm_per_s / k.acceleration_mm_per_s2;  // mm: speeding up and slowing down
    if (length_mm >= ramps) return Seconds(length_mm / feed_mm_per_s + feed_mm_per_s / k.acceleration_mm_per_s2);
    return Seconds(2 * std::sqrt(length_mm / k.acceleration_mm_per_s2));
}

}  // namespace palpate
