#include "planner/prober.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace palpate {
namespace {

Options with_epsilon(double epsilon) {
    Options options;
    options.epsilon = epsilon;
    return options;
}

TEST(CheckOptions, RefusesWhatMakesNoSense) {
    const Workspace workspace(Ball{Point::Zero(), 1});
    EXPECT_NO_THROW(check_options(workspace, with_epsilon(0.1)));
    for (const double epsilon : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
        EXPECT_THROW(check_options(workspace, with_epsilon(epsilon)), std::invalid_argument) << epsilon;
    }
    Options options = with_epsilon(0.1);
    options.reach = 0.0;
    EXPECT_THROW(check_options(workspace, options), std::invalid_argument);
    options = with_epsilon(0.1);
    options.refinement_floor = 1.5;
    EXPECT_THROW(check_options(workspace, options), std::invalid_argument);
    const auto refuses = [&](const auto& change) {
        options = with_epsilon(0.1);
        change();
        EXPECT_THROW(check_options(workspace, options), std::invalid_argument);
    };
    const Box box{{0, 0, 0}, {1, 1, 1}};
    refuses([&] { options.sizing.regions = {{box, 0.0}}; });
    refuses([&] { options.sizing.regions = {{box, 0.1, 1.1}}; });
    refuses([&] { options.sizing.regions = {{Box{box.max, box.min}, 0.1}}; });
    refuses([&] { options.sizing.regions = {{box, 1e-12}}; });
    refuses([&] { options.sizing.radii_of_curvature = -1; });
    refuses([&] { options.sizing.smallest = 0; });
    refuses([&] { options.min_angle = 0.53; });
    options = with_epsilon(0.1);
    options.seed_rays = {{{1, 2, 3}, {1, 2, 3}}};
    EXPECT_THROW(check_options(workspace, options), std::invalid_argument);
}

TEST(CheckOptions, RefusesWhatDoublesCannotTellApart) {
    EXPECT_NO_THROW(check_options(Workspace(Ball{Point::Zero(), 1e3}), with_epsilon(1e-4)));
    EXPECT_THROW(check_options(Workspace(Ball{Point::Zero(), 1e3}), with_epsilon(1e-6)), std::invalid_argument);
    EXPECT_THROW(check_options(Workspace(Ball{{1e9, 1e9, 0}, 2}), with_epsilon(0.3)), std::invalid_argument);
    EXPECT_THROW(check_options(Workspace(Ball{Point::Zero(), 1e150}), with_epsilon(1e149)), std::invalid_argument);
    EXPECT_THROW(check_options(Workspace(Ball{Point::Zero(), 1e-150}), with_epsilon(1e-151)), std::invalid_argument);
}

TEST(LowerBound, IsTheHexagonalLattice) {
    // A hexagonal lattice whose triangles have circumradius 1 has edges of √3, so 3√3/2 of area per point.
    EXPECT_NEAR(lower_bound_samples(3 * std::sqrt(3.0) / 2, 1.0), 1.0, 1e-15);
    EXPECT_NEAR(lower_bound_samples(10.0, 0.1) / lower_bound_samples(10.0, 0.2), 4.0, 1e-12);
}

}  // namespace
}  // namespace palpate
