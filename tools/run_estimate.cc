#include "tools/run_estimate.h"

#include <algorithm>

#include "planner/open_area.h"

namespace palpate {

// An estimate is never the end.
constexpr double kAlmostDone = 0.99;

void RunEstimate::note(std::chrono::nanoseconds now, const Progress& progress, const TriangleMesh& surface) {
    const OpenArea area = measure_open_area(surface, progress.epsilon);
    // Before that the guess is too small.
    if (area.covered > 0 && area.open < area.covered) covered_ = area.covered / (area.covered + area.open);
    // Counted in facets: samples are found long before the last facets between them.
    const auto facets = static_cast<double>(area.facets);
    // A touch brings a sample, or two facets, or is an audit.
    const double audited = 2 * static_cast<double>(progress.audited);
    const double audits = audited + 2 * static_cast<double>(progress.audits_left);
    const double whole = facets / covered_.value_or(progress.fraction_done) + 2 * static_cast<double>(progress.tolerance_left);
    share_ = whole > 0 ? facets / whole : 0;
    time_left_.note(now, facets + audited, whole + audits);
}

double RunEstimate::fraction_done(const Progress& progress) const {
    return std::min(kAlmostDone, covered_ || progress.tolerance_left > 0 ? share_ : progress.fraction_done);
}

}  // namespace palpate
