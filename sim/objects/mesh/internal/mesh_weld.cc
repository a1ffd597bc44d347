#include "sim/objects/mesh/internal/mesh_weld.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "sim/objects/mesh/internal/face_edges.h"

namespace palpate {
namespace {

using Index = std::uint32_t;
constexpr Index kUnused = std::numeric_limits<Index>::max();

std::vector<Index> each_itself(std::size_t size) {
    std::vector<Index> indices(size);
    std::iota(indices.begin(), indices.end(), Index{0});
    return indices;
}

void rename_corners(PolygonSoup& soup, const std::vector<Index>& names) {
    for (auto& polygon : soup.polygons) {
        for (Index& corner : polygon) corner = names[corner];
    }
}

// Points that stay, in cells of the reach: what is within reach of a point is in its cell or in one of those around.
class Grid {
public:
    Grid(const PolygonSoup& soup, const Point& origin, double reach) : soup_(soup), origin_(origin), reach_(reach) {}

    void add(Index i) { cells_[cell_of(soup_.points[i])].push_back(i); }

    // The nearest point within reach of point i that `allowed` lets pass; of equally near ones the first.
    template <class Allowed>
    [[nodiscard]] std::optional<Index> nearest_to(Index i, const Allowed& allowed) const {
        std::pair<double, Index> best{reach_, kUnused};
        const Cell middle = cell_of(soup_.points[i]);
        for (int n = 0; n < 27; ++n) {
            const auto cell = cells_.find({middle[0] + n % 3 - 1, middle[1] + n / 3 % 3 - 1, middle[2] + n / 9 - 1});
            if (cell == cells_.end()) continue;
            for (const Index j : cell->second) {
                const std::pair<double, Index> found{(soup_.points[i] - soup_.points[j]).norm(), j};
                if (found < best && allowed(j)) best = found;
            }
        }
        return best.second == kUnused ? std::nullopt : std::optional(best.second);
    }

private:
    using Cell = std::array<std::int64_t, 3>;

    [[nodiscard]] Cell cell_of(const Point& p) const {
        const Vector scaled = (p - origin_) / reach_;
        const auto floor = [](double x) { return static_cast<std::int64_t>(std::floor(x)); };
        return {floor(scaled.x()), floor(scaled.y()), floor(scaled.z())};
    }

    const PolygonSoup& soup_;
    Point origin_;
    double reach_;
    std::map<Cell, std::vector<Index>> cells_;
};

// The ends of open edges, each with the length of the shortest one there.
using Ends = std::map<Index, double>;

Ends ends_of(const PolygonSoup& soup) {
    Ends ends;
    for (const FaceEdge& edge : open_edges(face_edges(soup.polygons))) {
        const double length = (soup.points[edge.high] - soup.points[edge.low]).norm();
        for (const Index end : {edge.low, edge.high}) {
            double& shortest = ends.try_emplace(end, length).first->second;
            shortest = std::min(shortest, length);
        }
    }
    return ends;
}

// What each point becomes if `ends`, in order, join points before them.
std::vector<Index> joined_within(const PolygonSoup& soup, const Ends& ends, const Point& origin, double reach) {
    std::map<Index, std::vector<Index>> faces_at;
    for (const auto& [end, shortest] : ends) faces_at[end];
    for (Index f = 0; f < soup.polygons.size(); ++f) {
        for (const Index corner : soup.polygons[f]) {
            if (const auto at = faces_at.find(corner); at != faces_at.end()) at->second.push_back(f);
        }
    }
    std::vector<Index> names = each_itself(soup.points.size());
    Grid stay(soup, origin, reach);
    for (const auto& [i, shortest] : ends) {
        const auto may_be_the_same = [&, i = i, shortest = shortest](Index j) {
            if ((soup.points[i] - soup.points[j]).norm() > kWeldShare * std::min(shortest, ends.at(j))) return false;
            return std::ranges::none_of(faces_at[i], [&](Index f) {
                return std::ranges::any_of(soup.polygons[f], [&](Index corner) { return names[corner] == j; });
            });
        };
        if (const auto nearest = stay.nearest_to(i, may_be_the_same)) {
            names[i] = *nearest;
        } else {
            stay.add(i);
        }
    }
    return names;
}

}  // namespace

void join_equal_points(PolygonSoup& soup) {
    std::vector<Index> order = each_itself(soup.points.size());
    const auto less = [&](Index i, Index j) {
        const Point& p = soup.points[i];
        const Point& q = soup.points[j];
        return std::ranges::lexicographical_compare(p, q);
    };
    std::ranges::stable_sort(order, less);
    std::vector<Index> names = each_itself(soup.points.size());
    for (std::size_t i = 1; i < order.size(); ++i) {
        if (!less(order[i - 1], order[i])) names[order[i]] = names[order[i - 1]];
    }
    rename_corners(soup, names);
}

Weld weld_open_edges(PolygonSoup& soup) {
    constexpr int kSteps = 33;  // the first reach is 1e-15 of the size, the precision of a double
    Point low = Point::Constant(std::numeric_limits<double>::infinity());
    Point high = -low;
    for (const auto& polygon : soup.polygons) {
        for (const Index corner : polygon) {
            low = low.cwiseMin(soup.points[corner]);
            high = high.cwiseMax(soup.points[corner]);
        }
    }
    const double size = (high - low).stableNorm();
    if (!(size > 0.0)) return {};
    std::vector<Index> names = each_itself(soup.points.size());
    Ends ends = ends_of(soup);
    for (int step = kSteps; step >= 0 && !ends.empty(); --step) {
        const std::vector<Index> joined = joined_within(soup, ends, low, std::ldexp(kWeldReach * size, -step));
        if (std::ranges::equal(joined, each_itself(joined.size()))) continue;
        rename_corners(soup, joined);
        for (Index& name : names) name = joined[name];
        ends = ends_of(soup);
    }
    Weld weld;
    for (Index i = 0; i < names.size(); ++i) {
        if (names[i] == i) continue;
        ++weld.corners;
        weld.distance = std::max(weld.distance, (soup.points[i] - soup.points[names[i]]).norm());
    }
    return weld;
}

}  // namespace palpate
