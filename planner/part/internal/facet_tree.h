// A tree of boxes over the facets of a mesh: which of them are near something.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

// A place on a facet.
struct FacetPlace {
    std::uint32_t facet = 0;
    Vector share = Vector::Zero();  // of its corners: barycentric coordinates
    Point point = Point::Zero();
    double distance = std::numeric_limits<double>::infinity();  // mm, from what was asked about
};

using Corners = std::array<Point, 3>;

// The place of the triangle that is nearest to `p` (Ericson, Real-Time Collision Detection, 5.1.5), without its facet.
[[nodiscard]] FacetPlace nearest_on_triangle(const Corners& triangle, const Point& p);
// The place of the triangle that is nearest to the segment.
[[nodiscard]] FacetPlace nearest_on_triangle(const Corners& triangle, const Segment& segment);

class FacetTree {
public:
    // REQUIRES: `mesh` outlives this and stays as it is.
    explicit FacetTree(const TriangleMesh& mesh);

    // REQUIRES: the mesh has a facet.
    [[nodiscard]] FacetPlace nearest(const Point& p) const;
    // Calls `look` with the nearest place of each facet that is nearer to the segment than `within`.
    template <typename Look>
    void near(const Segment& segment, double within, const Look& look) const {
        visit([&](const Box& box) { return overlaps(box, segment, within); },
              [&](std::uint32_t facet) {
                  FacetPlace place = nearest_on_triangle(corners(facet), segment);
                  place.facet = facet;
                  if (place.distance < within) look(place);
              });
    }

    [[nodiscard]] Corners corners(std::uint32_t facet) const {
        const auto& [a, b, c] = mesh_->triangles[facet];
        return {mesh_->points[a], mesh_->points[b], mesh_->points[c]};
    }

private:
    struct Node {
        Box box;
        std::uint32_t first = 0;  // of the facets in order_
        std::uint32_t count = 0;
        std::uint32_t second = 0;  // child; the other one follows the node. 0: a leaf
    };
    static constexpr std::uint32_t kLeaf = 4;  // facets

    void split(std::uint32_t first, std::uint32_t count, const std::vector<Point>& middles);
    // Do the box of the segment, grown by `within`, and that one meet?
    [[nodiscard]] static bool overlaps(const Box& box, const Segment& segment, double within) {
        return (segment.source.cwiseMin(segment.target).array() - within <= box.max.array()).all() &&
               (segment.source.cwiseMax(segment.target).array() + within >= box.min.array()).all();
    }
    template <typename Test, typename Leaf>
    void visit(const Test& test, const Leaf& leaf) const {
        std::array<std::uint32_t, 64> open{};
        std::size_t count = nodes_.empty() ? 0 : 1;
        while (count > 0) {
            const std::uint32_t at = open[--count];
            const Node& node = nodes_[at];
            if (!test(node.box)) continue;
            if (node.second == 0) {
                for (std::uint32_t k = 0; k < node.count; ++k) leaf(order_[node.first + k]);
            } else {
                open[count++] = node.second;
                open[count++] = at + 1;
            }
        }
    }

    const TriangleMesh* mesh_;
    std::vector<std::uint32_t> order_;
    std::vector<Node> nodes_;
};

}  // namespace palpate
