#include "planner/check_options.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace palpate::check_options_test {
namespace {

Options with_epsilon(double epsilon) {
    Options options;
    options.epsilon = epsilon;
    return options;
}

TEST(CheckOptions, RefusesWhatMakesNoSense) {
    const Region workspace(Ball{Point::Zero(), 1});
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
    refuses([&] { options.seed_rays = {{{1, 2, 3}, {1, 2, 3}}}; });
    refuses([&] { options.standoff = 0; });
    refuses([&] { options.trust = 1.5; });
    refuses([&] { options.strategy.infer = Strategy::Infer::reach; });
    refuses([&] { options.audit = 1.5; });
    refuses([&] { options.audit = std::nan(""); });
    refuses([&] { options.strategy.infer = static_cast<Strategy::Infer>(7); });
    refuses([&] { options.budget.displacement = -1; });
    refuses([&] { options.budget.machine_time = std::numeric_limits<double>::infinity(); });
}

TEST(CheckOptions, RefusesAnOracleThatMakesNoSense) {
    const Region workspace(Ball{Point::Zero(), 1});
    const auto refuses = [&](const auto& change) {
        OracleTraits traits;
        change(traits);
        EXPECT_THROW(check_options(workspace, with_epsilon(0.1), traits), std::invalid_argument);
    };
    refuses([](OracleTraits& traits) { traits.touch_error = -1e-3; });
    refuses([](OracleTraits& traits) { traits.touch_error = 0.006; });  // epsilon is 20 of it at least
    refuses([](OracleTraits& traits) { traits.retract = std::nan(""); });
    refuses([](OracleTraits& traits) { traits.overtravel = 0; });
    refuses([](OracleTraits& traits) { traits.rates.probe_feed_mm_per_s = 0; });
    refuses([](OracleTraits& traits) { traits.rates.touch = Seconds(-1); });
    EXPECT_NO_THROW(check_options(workspace, with_epsilon(0.1), {.touch_error = 0.005, .retract = 0, .overtravel = 2, .rates = {}}));
}

TEST(CheckOptions, RefusesWhatDoublesCannotTellApart) {
    EXPECT_NO_THROW(check_options(Region(Ball{Point::Zero(), 1e3}), with_epsilon(1e-4)));
    EXPECT_THROW(check_options(Region(Ball{Point::Zero(), 1e3}), with_epsilon(1e-6)), std::invalid_argument);
    EXPECT_THROW(check_options(Region(Ball{{1e9, 1e9, 0}, 2}), with_epsilon(0.3)), std::invalid_argument);
    EXPECT_THROW(check_options(Region(Ball{Point::Zero(), 1e150}), with_epsilon(1e149)), std::invalid_argument);
    EXPECT_THROW(check_options(Region(Ball{Point::Zero(), 1e-150}), with_epsilon(1e-151)), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::check_options_test
