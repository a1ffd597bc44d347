#include "planner/prober.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include "planner/internal/run.h"

namespace palpate {
namespace {

// Coordinates are doubles, with 2^-53 ~ 1e-16 of relative rounding; seed facets are ε/64 small, circumcentres lose some
// 1e5 of it (internal/dual_line.h). Below this share of the coordinates, ε is not safely above that.
constexpr double kLeastEpsilonPerCoordinate = 1e-8;
// DESIGN section 7.
constexpr double kLeastEpsilonPerTouchError = 20.0;
// Squares and cubes of lengths must stay in the range of double.
constexpr double kRounding = 1e-12;
constexpr double kLeastLength_mm = 1e-30;
constexpr double kGreatestLength_mm = 1e30;

}  // namespace

void check_options(const Workspace& workspace, const Options& options) {
    const auto positive = [](double x) { return std::isfinite(x) && x > 0; };
    if (!positive(options.epsilon)) throw std::invalid_argument("epsilon must be positive and finite");
    if (options.reach && !positive(*options.reach)) throw std::invalid_argument("reach must be positive and finite");
    if (!(options.refinement_floor > 0 && options.refinement_floor <= 1))
        throw std::invalid_argument("refinement_floor must lie in (0, 1]");
    for (const Segment& ray : options.seed_rays) {
        if (!ray.source.allFinite() || !ray.target.allFinite() || ray.source == ray.target) {
            throw std::invalid_argument("a seed ray needs two different finite points");
        }
    }
    double smallest = options.epsilon;
    for (const RegionOfInterest& region : options.sizing.regions) {
        if (!positive(region.size) || !(region.slope >= 0 && region.slope <= 1))
            throw std::invalid_argument("a region of sizing needs a positive size and a slope in [0, 1]");
        if (!(region.box.min.array() <= region.box.max.array()).all() || !region.box.min.allFinite() || !region.box.max.allFinite())
            throw std::invalid_argument("a region of sizing needs a box of finite corners, the lowest first");
        smallest = std::min(smallest, region.size);
    }
    const Sizing& sizing = options.sizing;
    if (!(sizing.radii_of_curvature >= 0 && std::isfinite(sizing.radii_of_curvature)) || (sizing.smallest && !positive(*sizing.smallest)))
        throw std::invalid_argument("sizing by curvature must not be negative, and its smallest size must be positive");
    if (sizing.smallest && sizing.radii_of_curvature > 0) smallest = std::min(smallest, *sizing.smallest);
    if (!(options.min_angle >= 0 && options.min_angle <= std::numbers::pi / 6 + kRounding))
        throw std::invalid_argument("min_angle must lie in [0, 30] degrees: above, refinement need not end");
    if (!(options.touch_error >= 0 && std::isfinite(options.touch_error)) || !(options.retract >= 0 && std::isfinite(options.retract)))
        throw std::invalid_argument("touch_error and retract must be finite and not negative");
    if (smallest < kLeastEpsilonPerTouchError * options.touch_error) {
        std::ostringstream message;
        message << "epsilon = " << smallest << " mm is below " << kLeastEpsilonPerTouchError << " x what touches may be wrong by, "
                << options.touch_error << " mm: make it larger, or measure more exactly";
        throw std::invalid_argument(message.str());
    }
    const double coordinates = workspace.center().cwiseAbs().maxCoeff() + workspace.radius();
    if (coordinates > kGreatestLength_mm || smallest < kLeastLength_mm) {
        throw std::invalid_argument("workspace or epsilon is out of the range of lengths, 1e-30 to 1e30 mm: choose other units");
    }
    if (smallest < kLeastEpsilonPerCoordinate * coordinates) {
        std::ostringstream message;
        message << (smallest < options.epsilon ? "the smallest size = " : "epsilon = ") << smallest
                << " mm is below 1e-8 of the workspace's coordinates (up to " << coordinates
                << " mm), too fine for double precision: make it larger, the workspace smaller, or move the workspace nearer to the origin";
        throw std::invalid_argument(message.str());
    }
}

double lower_bound_samples(double area, double epsilon) { return 2 * area / (3 * std::numbers::sqrt3 * epsilon * epsilon); }

Result probe_surface(SurfaceOracle& oracle, const Workspace& workspace, const Options& options, const Observer& observer) {
    check_options(workspace, options);
    Run run(oracle, workspace, options, observer);
    run.execute();
    return run.result();
}

}  // namespace palpate
