#include "sim/probe/probe_errors.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "planner/random.h"

namespace palpate {
namespace {

// The same on every platform, which std::uniform_real_distribution is not. From [0, 1).

bool happens(double share, std::mt19937_64& random) { return share > 0.0 && uniform(random) < share; }

// Where the lobes begin: the x axis, as far as it is across the stylus.
Vector zero_azimuth(const Vector& axis) {
    constexpr double kAlong = 0.9;
    const Vector reference = std::abs(axis.x()) < kAlong ? Vector::UnitX() : Vector::UnitY();
    return (reference - reference.dot(axis) * axis).normalized();
}

}  // namespace

bool ProbeErrors::is_any() const {
    const bool is_late = sigma_mm != 0.0 || latency.count() != 0.0 || lobes_mm != 0.0 ||
                         std::ranges::any_of(harmonics_mm, [](double a) { return a != 0.0; });
    const bool bends = trigger_force_n * (compliance_across_mm_per_n + compliance_along_mm_per_n) != 0.0;
    const bool is_elsewhere =
        !backlash_mm.isZero(0) || !drift_mm_per_hour.isZero(0) || !drift_mm_per_1000_touches.isZero(0) || !swing_mm.isZero(0);
    return is_late || bends || is_elsewhere || false_triggers != 0.0 || misses != 0.0 || bounces != 0.0;
}

// The lobes are lobes_mm (1/2 + s² - s³/2 cos 3φ): twice as much in three directions across the axis as between them, half as much along
// it, as the lever of a kinematic seat makes it, without cusps.
double ProbeErrors::pretravel(const Vector& normal) const {
    const double along = normal.dot(axis);
    const Vector first = zero_azimuth(axis);
    const double x = normal.dot(first);
    const double y = normal.dot(axis.cross(first));
    const double across = x * x + y * y;
    const double lobes = lobes_mm * (0.5 + across - 0.5 * (x * x * x - 3 * x * y * y));
    const double bend = trigger_force_n * (compliance_across_mm_per_n * across + compliance_along_mm_per_n * along * along);
    return lobes + bend - LobingMap{harmonics_mm, axis}.pretravel(normal);
}

double ProbeErrors::touch_error(double feed_mm_per_s) const {
    double harmonics = 0.0;
    // No harmonic of degrees 2 and 3 is greater than sqrt(2 · 3 + 1) anywhere.
    for (const double a : harmonics_mm) harmonics += std::sqrt(7.0) * std::abs(a);
    const double bend = trigger_force_n * std::max(compliance_across_mm_per_n, compliance_along_mm_per_n);
    return kSigmas * sigma_mm + 2 * lobes_mm + bend + harmonics + latency.count() * feed_mm_per_s + backlash_mm.norm() + swing_mm.norm() +
           drift_mm_per_hour.norm() + drift_mm_per_1000_touches.norm();
}

Vector ProbeErrors::drift_at(Seconds time, std::uint64_t touches) const {
    constexpr double kHour = 3600.0;  // s
    const double turn = 2 * std::numbers::pi * (time / swing_period);
    return time.count() / kHour * drift_mm_per_hour + static_cast<double>(touches) / 1000.0 * drift_mm_per_1000_touches +
           std::sin(turn) * swing_mm;
}

ProbeErrorDraws::ProbeErrorDraws(const ProbeErrors& errors)
    : errors_(errors), touches_(errors.seed), misses_(errors.seed + 1), bounces_(errors.seed + 2), false_triggers_(errors.seed + 3) {}

double ProbeErrorDraws::lateness(const Vector& direction, const Vector& normal) {
    return errors_.pretravel(normal, -direction.dot(normal)) + (errors_.sigma_mm > 0.0 ? errors_.sigma_mm * gaussian() : 0.0);
}

bool ProbeErrorDraws::misses() { return happens(errors_.misses, misses_); }
bool ProbeErrorDraws::bounces() { return happens(errors_.bounces, bounces_); }

std::optional<double> ProbeErrorDraws::false_trigger() {
    if (!happens(errors_.false_triggers, false_triggers_)) return std::nullopt;
    return uniform(false_triggers_);
}

// Box and Muller: std::normal_distribution is another one in every library.
double ProbeErrorDraws::gaussian() {
    const double radius = std::sqrt(-2 * std::log(1.0 - uniform(touches_)));
    return radius * std::cos(2 * std::numbers::pi * uniform(touches_));
}

}  // namespace palpate
