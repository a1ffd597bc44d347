#include "sim/machines/grbl/internal/grbl_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "devices/motion_model.h"
#include "sim/machines/grbl/internal/grbl_errors.h"

namespace palpate {
namespace {

// The ones that are told with three decimals; the rest are whole.
bool is_fractional(int number) {
    constexpr std::array kFractional{11, 12, 24, 25, 27};
    return number >= 100 || std::ranges::find(kFractional, number) != kFractional.end();
}

}  // namespace

GrblSettings::GrblSettings(const VirtualGrblOptions& options, const VirtualToolOptions& tool)
    : values_{{0, 10}, {1, 25}, {2, 0},   {3, 0},    {4, 0},    {5, 0},  {6, 0},     {11, 0.01}, {12, 0.002},
              {21, 0}, {23, 0}, {24, 25}, {25, 500}, {26, 250}, {27, 1}, {30, 1000}, {31, 0},    {32, 0}} {
    values_[kStatusMask] = options.status_mask;
    values_[kInches] = options.report_inches ? 1 : 0;
    values_[kSoftLimits] = options.soft_limits ? 1 : 0;
    values_[kHoming] = options.homing ? 1 : 0;
    const double steps_per_mm = 1.0 / tool.motion.resolution_mm;
    for (int axis = 0; axis < 3; ++axis) {
        values_[100 + axis] = steps_per_mm;
        values_[kMaxFeed + axis] = options.max_feed_mm_per_s * kSecondsPerMinute;
        values_[120 + axis] = tool.motion.acceleration_mm_per_s2;
        values_[130 + axis] = tool.limits.max[axis] - tool.limits.min[axis];
    }
}

int GrblSettings::set(int number, double value) {
    const auto it = values_.find(number);
    if (it == values_.end()) return kUnknownSetting;
    if (value < 0.0) return kNegative;
    if (number == kSoftLimits && value != 0.0 && !homing()) return kSoftLimitsNeedHoming;
    it->second = value;
    if (number == kHoming && value == 0.0) values_[kSoftLimits] = 0.0;
    return 0;
}

std::string GrblSettings::dump() const {
    std::string text;
    for (const auto& [number, value] : values_) {
        text += fmt::format("${}={:.{}f}\r\n", number, value, is_fractional(number) ? 3 : 0);
    }
    return text;
}

unsigned GrblSettings::status_mask() const {
    constexpr double kMasks = 256.0;  // it is a byte
    return static_cast<unsigned>(std::fmod(values_.at(kStatusMask), kMasks));
}

double GrblSettings::max_feed_mm_per_s() const {
    return std::min({values_.at(kMaxFeed), values_.at(kMaxFeed + 1), values_.at(kMaxFeed + 2)}) / kSecondsPerMinute;
}

}  // namespace palpate
