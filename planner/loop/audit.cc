#include "planner/loop/audit.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace palpate {

std::size_t Audit::quota(std::size_t inferred, std::size_t samples) const {
    if (!(share_ > 0)) return 0;
    const auto of_samples = static_cast<std::size_t>(kLargestPerSample * static_cast<double>(samples));
    const auto of_facets = static_cast<std::size_t>(std::ceil(share_ * static_cast<double>(inferred)));
    return std::min({std::max(of_facets, std::min(kLeast, of_samples)), kEnough, inferred});
}

std::vector<Audit::Facet> Audit::draw(std::vector<Facet> inferred, std::size_t samples) {
    const std::size_t wanted = quota(inferred.size() + touched_, samples);
    std::erase_if(inferred, [&](const Facet& facet) { return drawn_.contains(facet); });
    const std::size_t count = wanted > touched_ ? std::min<std::size_t>(wanted - touched_, inferred.size()) : 0;
    // Whatever order they come in; a standard distribution is not the same everywhere.
    std::ranges::sort(inferred);
    for (std::size_t k = 0; k < count; ++k) {
        std::swap(inferred[k], inferred[k + random_() % (inferred.size() - k)]);
        drawn_.insert(inferred[k]);
    }
    inferred.resize(count);
    return inferred;
}

void Audit::note(bool agrees) {
    ++touched_;
    wrong_ += agrees ? 0 : 1;
}

}  // namespace palpate
