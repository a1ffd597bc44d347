#include "planner/prober.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "planner/internal/run.h"

namespace palpate {
namespace {

void validate(const Options& options) {
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
}

}  // namespace

double lower_bound_samples(double area, double epsilon) { return 2 * area / (3 * std::numbers::sqrt3 * epsilon * epsilon); }

Result probe_surface(SurfaceOracle& oracle, const Workspace& workspace, const Options& options, const Observer& observer) {
    validate(options);
    Run run(oracle, workspace, options, observer);
    run.execute();
    return run.result();
}

}  // namespace palpate
