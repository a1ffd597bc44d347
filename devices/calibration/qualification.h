// What touches of a calibrated sphere say of a probe: its effective radius, its lobes, how well it repeats.
//
// Notation: c the sphere's centre, R its radius, p a touched centre of the ball, n = (p - c) / |p - c|. The model is
//   |p - c| = R + r + sum over k of a_k Y_k(n),
// with r the effective radius and Y_k the harmonics of degrees 2 and 3 (lobing_map.h). Nothing but c makes it non-linear.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "devices/calibration/lobing_map.h"

namespace palpate {

// A probe that cannot be qualified from what was touched. The message says why, and what to do.
class QualificationError : public std::runtime_error {
public:
    explicit QualificationError(const std::string& message, std::vector<std::size_t> outliers = {})
        : std::runtime_error(message), outliers_(std::move(outliers)) {}

    // Touches, from 0, that do not fit to the others; empty if the reason is another.
    [[nodiscard]] const std::vector<std::size_t>& outliers() const { return outliers_; }

private:
    std::vector<std::size_t> outliers_;
};

struct ReferenceSphere {
    Point center = Point::Zero();  // mm: about
    double diameter = 0.0;         // mm, > 0: as its certificate says
};

struct SphereTouch {
    Point position = Point::Zero();     // mm: the ball's centre at the trigger, as the machine says
    Vector approach = Vector::UnitZ();  // unit: where the tool was going; within 25 degrees of the sphere's inward normal
};

struct SphereTouches {
    // One for each direction, 25 at least; the first 25 in ISO 10360-5's pattern (touch_plan.h).
    std::vector<SphereTouch> touches;
    // Further ones, each group in one direction: nothing but the repeatability comes from them.
    std::vector<std::vector<SphereTouch>> repeats;
};

struct Qualification {
    Point center = Point::Zero();      // mm: of the sphere
    double effective_radius_mm = 0.0;  // of the ball, less the mean pre-travel
    LobingMap lobing;
    std::vector<double> residuals_mm;  // by touch: outwards, beside what radius and map say
    double rms_mm = 0.0;               // of them, over touches less unknowns: an estimate of what one more touch would be off by
    double repeatability_mm = 0.0;     // standard deviation of repeated touches
    double form_error_mm = 0.0;        // of ISO's 25 touches, once corrected
    double raw_form_error_mm = 0.0;    // of the same, as touched: what the probe is worth without its map
    double axial_sigma_mm = 0.0;       // standard deviation of the centre along the tool's axis, from the RMS
    double condition = 0.0;            // of the fit
};

// Centre, radius, degrees 2 and 3.
inline constexpr std::size_t kQualificationUnknowns = 3 + 1 + LobingMap::kCoefficients;
inline constexpr std::size_t kIsoTouches = 25;
// What the residuals' RMS may be, as a multiple of the repeatability.
inline constexpr double kMostMisfit = 3.0;

// Least squares over all touches. `axis`: unit, from the ball to the holder. `resolution_mm`, > 0: of the machine's positions, which
// repeated touches need not show: the repeatability counts as resolution / sqrt(12) at least.
// Throws QualificationError on
//  - a diameter that is not positive; numbers that are not finite; an approach that does not lead to the sphere,
//  - fewer than 25 touches (unknowns are 16), or no repeated ones,
//  - touches that leave unknowns open (their spread),
//  - outliers: all are named, none is left out,
//  - residuals whose RMS is more than kMostMisfit times the repeatability.
// On one half of a sphere a shift along the axis looks much like a larger radius with a little of the harmonics of order 0: centre, radius
// and map are each less well known than their sum (the centre along the axis to 8 times the repeatability from 50 touches, 12 from 25). So
// they belong together: what they miss shifts a measured part as a whole, by some axial_sigma_mm, and does not deform it.
[[nodiscard]] Qualification qualify(const SphereTouches& touches, const ReferenceSphere& sphere, const Vector& axis, double resolution_mm);

// mm: standard deviation of the touched centres along their approach within groups, pooled. Throws QualificationError if no group has two.
[[nodiscard]] double repeatability(const std::vector<std::vector<SphereTouch>>& groups);

// mm: farthest less nearest from the centre of the sphere that fits to the touches best (Gaussian, its radius free), ISO 10360-5's P_FTU
// on its 25 points. Each is corrected by the map first. Throws QualificationError if the touches have no such sphere.
[[nodiscard]] double form_error(const std::vector<SphereTouch>& touches, const Point& about_center, const LobingMap& map = {});

// The sphere through touched centres, its radius free, without lobes: four or more. Throws QualificationError if they leave it open, or
// are not finite.
[[nodiscard]] Ball fit_sphere(const std::vector<SphereTouch>& touches, const Point& about_center);

// The centre of that sphere as a probe finds it that was qualified, from four touches or more: exact to the repeatability, so that drift
// shows. Throws QualificationError if the touches leave it open, or are not finite.
[[nodiscard]] Point locate_sphere(const std::vector<SphereTouch>& touches, const ReferenceSphere& sphere, double effective_radius_mm,
                                  const LobingMap& map);

}  // namespace palpate
