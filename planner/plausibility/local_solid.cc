#include "planner/plausibility/local_solid.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

// Samples seen under a smaller sine from each other's planes do not tell how these are joined, ...
constexpr double kEdgeOn = 0.05;
// ... which matters unless the planes are alike.
constexpr double kAlike = 0.98;
// mm per mm: what counts as on a plane.
constexpr double kSamePlane = 1e-9;

// Of the members, the one with the lowest number and all that are joined to it by chains of pairs that are `convex` (or are not).
template <typename Pairs>
unsigned component(const Pairs& convex, bool which, unsigned members, std::size_t count) {
    unsigned found = members & (~members + 1);
    for (unsigned before = 0; before != found;) {
        before = found;
        for (std::size_t i = 0; i < count; ++i) {
            if (!(found >> i & 1U)) continue;
            for (std::size_t j = 0; j < count; ++j) {
                if (j != i && (members >> j & 1U) && convex[i][j] == which) found |= 1U << j;
            }
        }
    }
    return found;
}

}  // namespace

void LocalSolid::add(const Point& sample, const Vector& normal) {
    const std::size_t n = count_++;
    samples_[n] = sample;
    normals_[n] = normal;
    for (std::size_t i = 0; i < n; ++i) {
        const Vector to = sample - samples_[i];
        const double sine = (normals_[i].dot(to) - normal.dot(to)) / (2 * to.norm());
        convex_[i][n] = convex_[n][i] = sine <= 0;
        if (!(std::abs(sine) > kEdgeOn) && normals_[i].dot(normal) < kAlike) unsure_[unsure_count_++] = {i, n};
    }
}

LocalSolid::Heights LocalSolid::heights_at(const Point& x) const {
    Heights heights{};
    for (std::size_t i = 0; i < count_; ++i) heights[i] = normals_[i].dot(x - samples_[i]);
    return heights;
}

// `clear` becomes false if the members cannot be taken apart.
double LocalSolid::height_by(const Pairs& convex, const Heights& heights, unsigned members, bool& clear) const {
    if ((members & (members - 1)) == 0) {
        std::size_t only = 0;
        while (!(members >> only & 1U)) ++only;
        return heights[only];
    }
    for (const bool which : {true, false}) {
        const unsigned first = component(convex, which, members, count_);
        if (first == members) continue;
        // Between the parts there are none of those pairs: without convex ones it is a union, otherwise an intersection.
        const double one = height_by(convex, heights, first, clear);
        const double other = height_by(convex, heights, members & ~first, clear);
        return which ? std::min(one, other) : std::max(one, other);
    }
    clear = false;
    return 0;
}

std::optional<double> LocalSolid::height(const Point& x) const {
    const Heights heights = heights_at(x);
    const unsigned all = (1U << count_) - 1;
    bool clear = true;
    double result = height_by(convex_, heights, all, clear);
    if (!clear) return std::nullopt;
    // All ways to join those pairs that leave it open.
    for (unsigned turned = 1; turned < 1U << unsure_count_; ++turned) {
        Pairs other = convex_;
        for (std::size_t k = 0; k < unsure_count_; ++k) {
            const auto [i, j] = unsure_[k];
            other[i][j] = other[j][i] = convex_[i][j] != ((turned >> k & 1U) != 0);
        }
        const double height = height_by(other, heights, all, clear);
        if (!clear || (height > 0) != (result > 0)) return std::nullopt;
        if (std::abs(height) < std::abs(result)) result = height;
    }
    return result;
}

std::optional<LocalSolid::Crossing> LocalSolid::crossing(const Point& origin, const Vector& direction) const {
    std::optional<Crossing> best;
    const unsigned all = (1U << count_) - 1;
    for (std::size_t k = 0; k < count_; ++k) {
        const double slope = normals_[k].dot(direction);
        if (slope == 0) continue;
        const double at = normals_[k].dot(samples_[k] - origin) / slope;
        if (best && std::abs(best->at) <= std::abs(at)) continue;
        const Point x = origin + at * direction;
        Heights heights = heights_at(x);
        heights[k] = 0;  // to rounding it is
        bool clear = true;
        const double height = height_by(convex_, heights, all, clear);
        if (clear && std::abs(height) <= kSamePlane * (x - samples_[k]).norm()) best = Crossing{at, slope};
    }
    return best;
}

}  // namespace palpate
