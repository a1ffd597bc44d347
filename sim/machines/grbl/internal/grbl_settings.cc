#include "sim/machines/grbl/internal/grbl_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "devices/motion_model.h"
#include "sim/machines/grbl/internal/grbl_errors.h"

namespace palpate {
namespace {

// Of $10; the first two are Grbl's, too.
constexpr unsigned kMachinePosition = 1U;
constexpr unsigned kBuffers = 2U;
constexpr unsigned kPins = 16U;
constexpr unsigned kOffset = 32U;
constexpr unsigned kOverrides = 64U;
constexpr unsigned kProbes = 128U;
constexpr unsigned kAllReports = 511U;
// What FluidNC has in a file of its own, not in settings, is below.
constexpr int kFirstOfAxes = 100;

// The ones that are told with three decimals; the rest are whole.
bool is_fractional(int number) {
    constexpr std::array kFractional{11, 12, 24, 25, 27};
    return number >= 100 || std::ranges::find(kFractional, number) != kFractional.end();
}

}  // namespace

GrblSettings::GrblSettings(const VirtualGrblOptions& options, const VirtualToolOptions& tool)
    : first_told_(options.dialect == GrblDialect::fluidnc ? kFirstOfAxes : 0),
      has_report_bits_(options.dialect == GrblDialect::grblhal),
      built_{.pins = options.reports_pins,
             .offset = options.reports_offset,
             .overrides = options.reports_overrides,
             .probes = options.reports_probes},
      values_{{0, 10}, {1, 25}, {2, 0},   {3, 0},    {4, 0},    {5, 0},  {6, 0},     {11, 0.01}, {12, 0.002},
              {21, 0}, {23, 0}, {24, 25}, {25, 500}, {26, 250}, {27, 1}, {30, 1000}, {31, 0},    {32, 0}} {
    values_[kStatusMask] = options.status_mask;
    if (has_report_bits_) {
        const unsigned told = kAllReports & ~((built_.pins ? 0 : kPins) | (built_.offset ? 0 : kOffset) |
                                              (built_.overrides ? 0 : kOverrides) | (built_.probes ? 0 : kProbes) | kMachinePosition);
        values_[kStatusMask] = static_cast<double>(static_cast<unsigned>(options.status_mask) | told);
    }
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
        if (number < first_told_ && number != kStatusMask && number != kInches) continue;
        text += fmt::format("${}={:.{}f}\r\n", number, value, is_fractional(number) ? 3 : 0);
    }
    return text;
}

GrblSettings::Reports GrblSettings::reports() const {
    const auto mask = static_cast<unsigned>(std::min(values_.at(kStatusMask), 65535.0));
    const auto has = [mask](unsigned bit) { return (mask & bit) != 0U; };
    Reports reports = built_;
    reports.machine_position = has(kMachinePosition);
    reports.buffers = has(kBuffers);
    if (!has_report_bits_) return reports;
    reports.pins = has(kPins);
    reports.offset = has(kOffset);
    reports.overrides = has(kOverrides);
    reports.probes = has(kProbes);
    return reports;
}

double GrblSettings::max_feed_mm_per_s() const {
    return std::min({values_.at(kMaxFeed), values_.at(kMaxFeed + 1), values_.at(kMaxFeed + 2)}) / kSecondsPerMinute;
}

}  // namespace palpate
