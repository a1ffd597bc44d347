#include "planner/check_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "planner/number_text.h"

namespace palpate {
namespace {

// Coordinates are doubles, with 2^-53 ~ 1e-16 of relative rounding; seed facets are ε/64 small, circumcentres lose some
// 1e5 of it (planner/delaunay/dual_line.h). Below this share of the coordinates, ε is not safely above that.
constexpr double kLeastEpsilonPerCoordinate = 1e-8;
// planner/DESIGN.md, "Numerics".
constexpr double kLeastEpsilonPerTouchError = 20.0;
// Squares and cubes of lengths must stay in the range of double.
constexpr double kLeastLength_mm = 1e-30;
constexpr double kGreatestLength_mm = 1e30;
constexpr double kRounding = 1e-12;  // of angles in degrees

bool is_positive(double x) { return std::isfinite(x) && x > 0; }
bool is_not_negative(double x) { return std::isfinite(x) && x >= 0; }
bool is_positive_if_given(const std::optional<double>& x) { return !x || is_positive(*x); }
bool is_share(double x) { return x >= 0 && x <= 1; }

void require(bool good, const char* what) {
    if (!good) throw std::invalid_argument(what);
}

void check_strategy(const Strategy& strategy) {
    using S = Strategy;
    const auto is_one_of = [](auto value, auto last) { return static_cast<int>(value) >= 0 && value <= last; };
    require(is_one_of(strategy.refine, S::Refine::eager) && is_one_of(strategy.explore, S::Explore::closure) &&
                is_one_of(strategy.infer, S::Infer::automatic) && is_one_of(strategy.travel, S::Travel::free_space),
            "an option of the strategy has a value that is none of its own");
}

void check_seed_rays(const std::vector<Segment>& rays) {
    for (const Segment& ray : rays) {
        require(ray.source.allFinite() && ray.target.allFinite() && ray.source != ray.target,
                "a seed ray needs two different finite points");
    }
}

void check_sizing(const Sizing& sizing) {
    for (const RegionOfInterest& region : sizing.regions) {
        require(is_positive(region.size) && is_share(region.slope), "a region of sizing needs a positive size and a slope in [0, 1]");
        require((region.box.min.array() <= region.box.max.array()).all() && region.box.min.allFinite() && region.box.max.allFinite(),
                "a region of sizing needs a box of finite corners, the lowest first");
    }
    require(is_not_negative(sizing.radii_of_curvature) && is_positive_if_given(sizing.smallest),
            "sizing by curvature must not be negative, and its smallest size must be positive");
}

void check_earlier(const Surroundings& surroundings, const Options& options) {
    require(is_positive_if_given(options.earlier_limit), "earlier_limit must be positive and finite");
    require(options.earlier.empty() || options.inference() != Strategy::Infer::none,
            "infer: none concludes nothing from earlier touches: say infer: auto, or adaptive");
    for (std::size_t k = 0; k < options.earlier.size(); ++k) {
        const EarlierTouch& touch = options.earlier[k];
        require(touch.position.allFinite() && touch.from.allFinite(), "an earlier touch has a coordinate that is not finite");
        if (!surroundings.is_free(touch.position)) continue;
        throw std::invalid_argument(
            fmt::format("the earlier touch {} at {} lies outside the workspace: it has to contain all that was touched", k,
                        point_text(touch.position)));
    }
}

void check_budget(const Budget& budget) {
    require(is_positive_if_given(budget.displacement) && is_positive_if_given(budget.machine_time),
            "a budget of displacement or machine time must be positive and finite");
}

void check_traits(const OracleTraits& traits) {
    require(is_not_negative(traits.touch_error) && is_not_negative(traits.retract),
            "touch_error and retract must be finite and not negative");
    require(is_positive_if_given(traits.overtravel), "overtravel must be positive and finite");
    require(is_positive(traits.rates.travel_feed_mm_per_s) && is_positive(traits.rates.probe_feed_mm_per_s) &&
                is_not_negative(traits.rates.touch.count()),
            "feeds must be positive and finite, and the time of a touch not negative");
}

// mm: the smallest ball that may be asked for.
double smallest_size(const Options& options) {
    double smallest = options.epsilon;
    for (const RegionOfInterest& region : options.sizing.regions) smallest = std::min(smallest, region.size);
    if (options.sizing.smallest && options.sizing.radii_of_curvature > 0) smallest = std::min(smallest, *options.sizing.smallest);
    return smallest;
}

void check_touch_error(double smallest, double touch_error) {
    if (smallest >= kLeastEpsilonPerTouchError * touch_error) return;
    throw std::invalid_argument(fmt::format(
        "epsilon = {:.6g} mm is below {:.6g} x what touches may be wrong by, {:.6g} mm: make it larger, or measure more exactly", smallest,
        kLeastEpsilonPerTouchError, touch_error));
}

void check_doubles(const Region& region, double smallest, double epsilon) {
    const double coordinates = region.center().cwiseAbs().maxCoeff() + region.radius();
    require(coordinates <= kGreatestLength_mm && smallest >= kLeastLength_mm,
            "workspace or epsilon is out of the range of lengths, 1e-30 to 1e30 mm: choose other units");
    if (smallest >= kLeastEpsilonPerCoordinate * coordinates) return;
    throw std::invalid_argument(
        fmt::format("{} = {:.6g} mm is below 1e-8 of the workspace's coordinates (up to {:.6g} mm), too fine for double precision: make it "
                    "larger, the workspace smaller, or move the workspace nearer to the origin",
                    smallest < epsilon ? "the smallest size" : "epsilon", smallest, coordinates));
}

}  // namespace

void check_options(const Surroundings& surroundings, const Options& options, const OracleTraits& traits) {
    require(is_positive(options.epsilon), "epsilon must be positive and finite");
    require(is_positive_if_given(options.reach), "reach must be positive and finite");
    check_strategy(options.strategy);
    require(is_positive_if_given(options.standoff), "standoff must be positive and finite");
    require(is_share(options.audit), "audit must lie in [0, 1]");
    require(is_share(options.trust), "trust must lie in [0, 1]");
    require(options.inference() != Strategy::Infer::reach || options.reach,
            "infer: reach needs probing.reach, a lower bound on the reach that you vouch for; without one say infer: auto, or adaptive");
    require(
        options.inference() != Strategy::Infer::reach || surroundings.known().empty(),
        "infer: reach proves nothing where a part stands on a fixture or meets the walls of an area, as S has a crease there: say infer: "
        "adaptive");
    check_seed_rays(options.seed_rays);
    check_earlier(surroundings, options);
    require(options.refinement_floor > 0 && options.refinement_floor <= 1, "refinement_floor must lie in (0, 1]");
    check_sizing(options.sizing);
    require(options.min_angle >= 0 && options.min_angle <= std::numbers::pi / 6 + kRounding,
            "min_angle must lie in [0, 30] degrees: above, refinement need not end");
    require(is_positive_if_given(options.tolerance) && is_positive_if_given(options.spacing_min),
            "tolerance and spacing_min must be positive and finite");
    require(!options.tolerance || *options.tolerance < options.epsilon, "tolerance must be below epsilon");
    require(!options.tolerance_box || (options.tolerance && options.tolerance_box->is_valid()),
            "tolerance_box needs a tolerance, and corners of which one is above the other");
    require(!options.tolerance ||
                (options.inference() == Strategy::Infer::adaptive && options.strategy.refine == Strategy::Refine::eager &&
                 options.strategy.explore == Strategy::Explore::closure && options.strategy.travel == Strategy::Travel::free_space),
            "a tolerance needs a front that guesses: strategy: adaptive");
    check_budget(options.budget);
    check_traits(traits);
    const double smallest = smallest_size(options);
    check_touch_error(smallest, traits.touch_error);
    check_doubles(surroundings.region(), smallest, options.epsilon);
}

}  // namespace palpate
