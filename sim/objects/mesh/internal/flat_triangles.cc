#include "sim/objects/mesh/internal/flat_triangles.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "sim/objects/internal/cgal_points.h"

namespace palpate {
namespace {

using Kernel = ExactPredicates;
using Index = std::uint32_t;
using Triangle = std::array<Index, 3>;
using Edge = std::pair<Index, Index>;  // low, high

bool flat(const TriangleMesh& mesh, const Triangle& t) {
    return CGAL::collinear(to_cgal(mesh.points[t[0]]), to_cgal(mesh.points[t[1]]), to_cgal(mesh.points[t[2]]));
}

constexpr double kRounding = 1e-6;  // of the mesh's size: single precision moves a corner by 2e-7

double size_of(const TriangleMesh& mesh) {
    Point low = mesh.points[mesh.triangles.front()[0]];
    Point high = low;
    for (const Triangle& t : mesh.triangles) {
        for (const Index i : t) {
            low = low.cwiseMin(mesh.points[i]);
            high = high.cwiseMax(mesh.points[i]);
        }
    }
    return (high - low).norm();
}

// By rounded lengths; for triangles with an area.
Edge longest_edge(const TriangleMesh& mesh, const Triangle& t) {
    const auto length = [&](const Edge& edge) { return (mesh.points[edge.first] - mesh.points[edge.second]).norm(); };
    const std::array<Edge, 3> edges{std::minmax(t[0], t[1]), std::minmax(t[1], t[2]), std::minmax(t[2], t[0])};
    return *std::ranges::max_element(edges, {}, length);
}

// Are the corners almost on one line?
bool sliver(const TriangleMesh& mesh, const Triangle& t, double height) {
    const Vector u = mesh.points[t[1]] - mesh.points[t[0]];
    const Vector v = mesh.points[t[2]] - mesh.points[t[0]];
    return u.cross(v).norm() <= height * std::max({u.norm(), v.norm(), (u - v).norm()});
}

Index third_corner(const Triangle& t, const Edge& edge) {
    return *std::ranges::find_if(t, [&](Index i) { return i != edge.first && i != edge.second; });
}

struct FlatTriangle {
    Edge long_edge;
    std::size_t face = 0;
};

// By length, exactly: with rounded ones, dropping might never end.
struct Shorter {
    const TriangleMesh& mesh;

    bool operator()(const FlatTriangle& a, const FlatTriangle& b) const {
        const auto end = [&](Index i) { return to_cgal(mesh.points[i]); };
        const auto order = Kernel().compare_squared_distance_3_object()(end(a.long_edge.first), end(a.long_edge.second),
                                                                        end(b.long_edge.first), end(b.long_edge.second));
        return order == CGAL::EQUAL ? a.face < b.face : order == CGAL::SMALLER;
    }
};

class FlatTriangles {
public:
    explicit FlatTriangles(TriangleMesh& mesh) : mesh_(mesh), dropped_(mesh.triangles.size(), false), flat_(Shorter{mesh}) {
        for (std::size_t f = 0; f < mesh.triangles.size(); ++f) enter(f);
    }

    void drop_all() {
        // The longest first: whatever is across its long edge and flat, too, lies within that edge, so that pieces only get shorter.
        while (!flat_.empty()) drop(flat_.rbegin()->face, flat_.rbegin()->long_edge);
    }

    // Returns how many triangles there were whose corner rounding has put beyond their long edge, onto the triangle across.
    std::size_t unfold_all(double height) {
        std::size_t count = 0;
        for (std::size_t f = 0; f < mesh_.triangles.size(); ++f) {
            if (dropped_[f] || !sliver(mesh_, mesh_.triangles[f], height)) continue;
            const Edge edge = longest_edge(mesh_, mesh_.triangles[f]);
            if (!folded(f, edge) && !within_rounding(f, edge)) continue;
            drop(f, edge);
            ++count;
        }
        return count;
    }

    void finish() {
        std::size_t f = 0;
        std::erase_if(mesh_.triangles, [&](const Triangle&) { return dropped_[f++]; });
    }

private:
    void enter(std::size_t f) {
        const Triangle& t = mesh_.triangles[f];
        for (std::size_t i = 0; i < 3; ++i) faces_[std::minmax(t[i], t[(i + 1) % 3])].push_back(f);
        if (flat(mesh_, t)) flat_.insert({long_edge(t), f});
    }

    void leave(std::size_t f) {
        const Triangle& t = mesh_.triangles[f];
        for (std::size_t i = 0; i < 3; ++i) std::erase(faces_[std::minmax(t[i], t[(i + 1) % 3])], f);
        if (flat(mesh_, t)) flat_.erase({long_edge(t), f});
    }

    // The edge of a flat triangle that the two others make up.
    [[nodiscard]] Edge long_edge(const Triangle& t) const {
        for (std::size_t i = 0; i < 3; ++i) {
            const Index a = t[(i + 1) % 3];
            const Index b = t[(i + 2) % 3];
            const Point& p = mesh_.points[t[i]];
            if (CGAL::collinear_are_ordered_along_line(to_cgal(mesh_.points[a]), to_cgal(p), to_cgal(mesh_.points[b]))) {
                return std::minmax(a, b);
            }
        }
        return std::minmax(t[0], t[1]);
    }

    // In one plane with the only other triangle at the edge, and on the same side: exactly, since only then do they overlap.
    [[nodiscard]] bool folded(std::size_t f, const Edge& edge) const {
        const std::vector<std::size_t>& faces = faces_.at(edge);
        if (faces.size() != 2) return false;
        const auto apex = [&](std::size_t face) { return to_cgal(mesh_.points[third_corner(mesh_.triangles[face], edge)]); };
        const auto other = faces[0] == f ? faces[1] : faces[0];
        const Kernel::Point_3 a = to_cgal(mesh_.points[edge.first]);
        const Kernel::Point_3 b = to_cgal(mesh_.points[edge.second]);
        return !CGAL::collinear(a, b, apex(f)) && !CGAL::collinear(a, b, apex(other)) && CGAL::coplanar(a, b, apex(f), apex(other)) &&
               CGAL::coplanar_orientation(a, b, apex(f), apex(other)) == CGAL::POSITIVE;
    }

    // So low that where its corner is, above the edge or below, was decided by rounding; with an only other triangle to be cut there.
    [[nodiscard]] bool within_rounding(std::size_t f, const Edge& edge) const {
        constexpr double kShare = 1e-12;  // of the length
        const double length = (mesh_.points[edge.first] - mesh_.points[edge.second]).norm();
        const std::vector<std::size_t>& faces = faces_.at(edge);
        return faces.size() == 2 && sliver(mesh_, mesh_.triangles[f], kShare * length) &&
               std::ranges::none_of(faces,
                                    [&](std::size_t face) { return face != f && sliver(mesh_, mesh_.triangles[face], kShare * length); });
    }

    // Joins it, a triangle whose corners are on one line or almost, with the triangle across its long edge, if there is one.
    void drop(std::size_t f, const Edge edge) {
        const Index middle = third_corner(mesh_.triangles[f], edge);
        leave(f);
        dropped_[f] = true;
        const std::vector<std::size_t> across = faces_[edge];
        if (across.size() != 1) return;  // nothing there to be cut
        const Triangle other = mesh_.triangles[across.front()];
        const Index apex = third_corner(other, edge);
        leave(across.front());
        if (apex == middle) {  // the same, the other way round: they close each other
            dropped_[across.front()] = true;
            return;
        }
        Triangle first = other;
        Triangle second = other;
        for (std::size_t i = 0; i < 3; ++i) {
            if (other[i] == apex) continue;
            (other[(i + 1) % 3] == apex ? first : second)[i] = middle;
        }
        dropped_[f] = false;
        mesh_.triangles[f] = first;
        mesh_.triangles[across.front()] = second;
        enter(f);
        enter(across.front());
    }

    TriangleMesh& mesh_;
    std::vector<bool> dropped_;
    std::map<Edge, std::vector<std::size_t>> faces_;
    std::set<FlatTriangle, Shorter> flat_;
};

}  // namespace

std::size_t count_flat_triangles(const TriangleMesh& mesh) {
    return static_cast<std::size_t>(std::ranges::count_if(mesh.triangles, [&](const Triangle& t) { return flat(mesh, t); }));
}

std::size_t drop_flat_triangles(TriangleMesh& mesh) {
    if (mesh.triangles.empty()) return 0;
    const double height = kRounding * size_of(mesh);
    if (std::ranges::none_of(mesh.triangles, [&](const Triangle& t) { return sliver(mesh, t, height); })) return 0;
    const std::size_t count = count_flat_triangles(mesh);
    FlatTriangles flat(mesh);
    flat.drop_all();
    const std::size_t unfolded = flat.unfold_all(height);
    flat.finish();
    return count + unfolded;
}

}  // namespace palpate
