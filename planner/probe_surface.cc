#include "planner/probe_surface.h"

#include <numbers>

#include "planner/check_options.h"
#include "planner/loop/probing_loop.h"

namespace palpate {

double lower_bound_samples(double area, double epsilon) { return 2 * area / (3 * std::numbers::sqrt3 * epsilon * epsilon); }

Result probe_surface(SurfaceOracle& oracle, const Surroundings& surroundings, const Options& options, const Observer& observer) {
    check_options(surroundings, options, oracle.traits());
    ProbingLoop run(oracle, surroundings, options, observer);
    run.execute();
    return run.result();
}

void check_seeds(SurfaceOracle& oracle, const Surroundings& surroundings, const Options& options) {
    check_options(surroundings, options, oracle.traits());
    const Observer nobody;
    ProbingLoop(oracle, surroundings, options, nobody).seed();
}

}  // namespace palpate
