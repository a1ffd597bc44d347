// The facets around every point of a mesh.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

// Unit; zero for a facet without area.
[[nodiscard]] Vector facet_normal(const TriangleMesh& mesh, std::uint32_t facet);
// rad, in [0, π].
[[nodiscard]] double angle_between(const Vector& u, const Vector& v);

class FacetFans {
public:
    // REQUIRES: `mesh` outlives this and stays as it is.
    explicit FacetFans(const TriangleMesh& mesh);

    // The points that a facet joins to it, or to one of those; not itself.
    [[nodiscard]] std::vector<std::uint32_t> two_rings(std::uint32_t point) const;

    [[nodiscard]] std::span<const std::uint32_t> around(std::uint32_t point) const {
        return std::span(facets_).subspan(first_[point], first_[point + 1] - first_[point]);
    }

private:
    const TriangleMesh* mesh_;
    std::vector<std::uint32_t> first_;
    std::vector<std::uint32_t> facets_;
};

}  // namespace palpate
