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

std::vector<Audit::Facet> Audit::draw(std::vector<Facet> inferred, std::size_t samples, std::optional<std::size_t> counted) {
    const std::size_t wanted = quota(inferred.size() + touched_, counted.value_or(samples));
    // Whatever order they come in.
    std::ranges::sort(inferred);
    std::erase_if(inferred, [&](const Facet& facet) { return drawn_.contains(facet); });
    const auto since =
        std::stable_partition(inferred.begin(), inferred.end(), [&](const Facet& facet) { return facet[2] < samples_ || samples_ == 0; });
    const std::vector<Facet> fresh(since, inferred.end());
    inferred.erase(since, inferred.end());
    const std::size_t of_fresh = wanted * fresh.size() / std::max<std::size_t>(1, fresh.size() + inferred.size());
    samples_ = samples;
    std::vector<Facet> chosen;
    const auto choose = [&](std::vector<Facet> from, std::size_t count) {
        count = std::min({count, from.size(), kEnough - std::min<std::size_t>(kEnough, touched_ + chosen.size())});
        for (std::size_t k = 0; k < count; ++k) {
            // A standard distribution is not the same everywhere.
            std::swap(from[k], from[k + random_() % (from.size() - k)]);
            chosen.push_back(from[k]);
            drawn_.insert(from[k]);
        }
    };
    choose(fresh, of_fresh);
    choose(std::move(inferred), wanted > touched_ ? wanted - touched_ : 0);
    return chosen;
}

void Audit::note(bool agrees) {
    ++touched_;
    wrong_ += agrees ? 0 : 1;
}

}  // namespace palpate
