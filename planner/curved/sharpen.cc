#include "planner/curved/internal/sharpen.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <span>

#include "planner/curved/internal/blend.h"
#include "planner/curved/internal/facet_sides.h"
#include "planner/curved/internal/local_spline.h"

namespace palpate {
namespace {

// rad: facets of one side turn by less. Those that cut a crease off turn by about half of its angle against both sides.
constexpr double kSmoothTurn = 0.35;
// Touches of one side, in two rings, that tell of a surface.
constexpr std::size_t kFewestOfSide = 7;
// A point with a second side that has so many of the touches of the first is on a crease itself.
constexpr double kAsMany = 0.75;
// Of an edge: a point is on the side of the other end if that one's surface passes so near.
constexpr double kOnSide = 0.02;
constexpr int kAdoptions = 2;
// Of a crease's height over the edge that cuts it off: what its sides' surprises may be at most.
constexpr double kMostSurprise = 0.25;
// Of the edge's length: how far from its middle the crease may be. Half of it at right angles, 0.87 where sides enclose 60°.
constexpr double kMostHeight = 0.87;
// rad: what a side may turn from a touch to the crease.
constexpr double kMostBend = 0.25;
// Parts of a split facet look where their side looks, as a cosine.
constexpr double kLeastTurn = 0.5;

constexpr std::uint32_t kNone = kNoFacet;

class Sharpening {
public:
    Sharpening(const TriangleMesh& mesh, const std::vector<double>& error, const std::vector<std::uint8_t>& flat, double most)
        : mesh_(mesh),
          error_(error),
          most_(most),
          apart_(pure_only(flat)),
          sides_(mesh, apart_, kSmoothTurn),
          main_(main_sides(sides_, apart_)) {}

    SharpMesh run() {
        for (int round = 0; round < kAdoptions; ++round) adopt();
        place_.resize(sides_.edges().size());
        for (std::uint32_t e = 0; e < sides_.edges().size(); ++e) place_[e] = crease_on(sides_.edges()[e]);
        for (bool changes = true; changes;) {
            changes = false;
            for (std::uint32_t f = 0; f < mesh_.triangles.size(); ++f) {
                if (!splits(f) || are_good(f, parts_of(f))) continue;
                for (std::size_t k = 0; k < 3; ++k) place_[sides_.edge(f, k)].reset();
                changes = true;
            }
        }
        return assembled();
    }

private:
    // Where a part's corner lies: a corner of the facet, on an edge from it on, or inside.
    enum class At : std::uint8_t { corner, edge, inside };
    struct Corner {
        At at;
        std::size_t k;
    };
    struct Part {
        std::array<Corner, 3> corners;
        std::uint32_t side;  // that it is on, or kNone
    };

    // By point: its side that has the most touches around it, and enough; kNone if there is none, or if another has about as many, as on a
    // crease. Facets that are `apart` make no side.
    [[nodiscard]] std::vector<std::uint32_t> main_sides(const FacetSides& sides, const std::vector<std::uint8_t>& apart) const {
        std::vector<std::uint32_t> found(mesh_.points.size(), kNone);
        std::vector<std::size_t> most(mesh_.points.size(), 0);
        std::vector<std::size_t> second(mesh_.points.size(), 0);
        for (std::uint32_t s = 0; s < sides.sides().size(); ++s) {
            const FacetSides::Side& side = sides.sides()[s];
            if (side.normal.isZero() || (!apart.empty() && apart[sides.facets(side).front()] != 0)) continue;
            const std::size_t touches = sides.rings(s, 2, LocalSpline::kMostSites).size();
            if (touches < kFewestOfSide) continue;
            const std::uint32_t v = side.point;
            second[v] = std::max(second[v], std::min(touches, most[v]));
            if (touches <= most[v]) continue;
            most[v] = touches;
            found[v] = s;
        }
        for (std::size_t v = 0; v < found.size(); ++v) {
            if (static_cast<double>(second[v]) > kAsMany * static_cast<double>(most[v])) found[v] = kNone;
        }
        return found;
    }
    // 1 for facets that are not wholly on one side, and for flat ones.
    [[nodiscard]] std::vector<std::uint8_t> pure_only(const std::vector<std::uint8_t>& flat) const {
        const FacetSides sides(mesh_, flat, kSmoothTurn);
        const std::vector<std::uint32_t> mains = main_sides(sides, flat);
        std::vector<std::uint8_t> apart(mesh_.triangles.size(), 0);
        for (std::uint32_t f = 0; f < apart.size(); ++f) {
            apart[f] = flat.empty() ? 0 : flat[f];
            for (std::size_t k = 0; k < 3; ++k) {
                if (sides.side(f, k) != mains[mesh_.triangles[f][k]]) apart[f] = 1;
            }
        }
        return apart;
    }

    const std::optional<LocalSpline>& spline(std::uint32_t s) {
        const auto found = splines_.find(s);
        if (found != splines_.end()) return found->second;
        std::vector<LocalSpline::Site> sites;
        for (const std::uint32_t other : sides_.rings(s, 2, LocalSpline::kMostSites)) {
            const FacetSides::Side& side = sides_.sides()[other];
            if (other == main_[side.point]) sites.push_back({mesh_.points[side.point], side.normal, error_[side.point]});
        }
        return splines_.emplace(s, LocalSpline::fit(sites, 1, sides_.sides()[s].spacing / std::sqrt(3.0), LocalSpline::Trend::plane))
            .first->second;
    }

    // A point beside a crease that has hardly a facet on one side: it is on the side of a neighbour whose surface passes through it.
    void adopt() {
        std::vector<std::uint32_t> candidates(mesh_.points.size(), kNone);
        std::vector<double> off(mesh_.points.size(), std::numeric_limits<double>::infinity());
        std::vector<std::uint8_t> several(mesh_.points.size(), 0);
        for (const MeshEdge& edge : sides_.edges()) {
            for (std::size_t end = 0; end < 2; ++end) {
                const std::uint32_t v = edge.points.at(end);
                const std::uint32_t side = main_[edge.points.at(1 - end)];
                if (main_[v] != kNone || side == kNone || !spline(side)) continue;
                const double length = (mesh_.points[edge.points[0]] - mesh_.points[edge.points[1]]).norm();
                const double here = std::abs(spline(side)->jet(mesh_.points[v]).value);
                if (here > kOnSide * length + error_[v]) continue;
                if (candidates[v] != kNone && sides_.sides()[side].normal.dot(sides_.sides()[candidates[v]].normal) < std::cos(kCrease))
                    several[v] = 1;
                if (here >= off[v]) continue;
                off[v] = here;
                candidates[v] = side;
            }
        }
        for (std::size_t v = 0; v < candidates.size(); ++v) {
            if (candidates[v] != kNone && several[v] == 0) main_[v] = candidates[v];
        }
    }

    std::optional<Point> crease_on(const MeshEdge& edge) {
        const std::uint32_t a = main_[edge.points[0]];
        const std::uint32_t b = main_[edge.points[1]];
        if (edge.count != 2 || a == kNone || b == kNone) return std::nullopt;
        const FacetSides::Side& one = sides_.sides()[a];
        const FacetSides::Side& other = sides_.sides()[b];
        if (one.normal.dot(other.normal) > std::cos(kCrease)) return std::nullopt;
        for (std::size_t which = 0; which < 2; ++which) {
            // One smooth surface, bent so much.
            const auto& corners = edge.corners.at(which);
            const std::uint32_t f = edge.facets.at(which);
            if (sides_.side(f, corners[0]) == a && sides_.side(f, corners[1]) == b) return std::nullopt;
        }
        const auto& at_a = spline(a);
        const auto& at_b = spline(b);
        if (!at_a || !at_b) return std::nullopt;
        const Point& p = mesh_.points[edge.points[0]];
        const Point& q = mesh_.points[edge.points[1]];
        const Point middle = (p + q) / 2;
        const SideSurface surface_a{*at_a, 0, 0};
        const SideSurface surface_b{*at_b, 0, 0};
        const auto place =
            crease_place(Blend({Share{&one, &surface_a, 1.0}, Share{}, Share{}}), Blend({Share{&other, &surface_b, 1.0}, Share{}, Share{}}),
                         middle, std::min(most_ + (p - q).norm() / 2, kMostHeight * (p - q).norm()));
        if (!place) return std::nullopt;
        // Sides that bend towards each other meet without a crease.
        const Vector here = at_a->jet(*place).gradient.normalized();
        const Vector there = at_b->jet(*place).gradient.normalized();
        if (here.dot(there) > std::cos(kCrease) || here.dot(one.normal) < std::cos(kMostBend) ||
            there.dot(other.normal) < std::cos(kMostBend))
            return std::nullopt;
        const double height = (*place - nearest_on({p, q}, *place)).norm();
        const double doubt =
            std::max(std::max(at_a->surprise(), at_b->surprise()), std::max(error_[edge.points[0]], error_[edge.points[1]]));
        if (height > most_ || doubt > kMostSurprise * height) return std::nullopt;
        return place;
    }

    [[nodiscard]] bool splits(std::uint32_t f) const {
        return place_[sides_.edge(f, 0)] || place_[sides_.edge(f, 1)] || place_[sides_.edge(f, 2)];
    }
    [[nodiscard]] std::vector<Part> parts_of(std::uint32_t f) const {
        std::vector<std::size_t> split;
        for (std::size_t k = 0; k < 3; ++k) {
            if (place_[sides_.edge(f, k)]) split.push_back(k);
        }
        const auto corner = [](std::size_t k) { return Corner{At::corner, k % 3}; };
        const auto edge = [](std::size_t k) { return Corner{At::edge, k % 3}; };
        const auto main = [&](std::size_t k) { return main_[mesh_.triangles[f][k % 3]]; };
        if (split.size() == 1) {
            const std::size_t k = split[0];
            return {{{corner(k), edge(k), corner(k + 2)}, main(k)}, {{edge(k), corner(k + 1), corner(k + 2)}, main(k + 1)}};
        }
        if (split.size() == 2) {
            // The corner c between both edges is alone on its side.
            const std::size_t c = (split[0] + 1) % 3 == split[1] ? split[1] : split[0];
            return {{{corner(c), edge(c), edge(c + 2)}, main(c)},
                    {{edge(c), corner(c + 1), edge(c + 2)}, main(c + 1)},
                    {{corner(c + 1), corner(c + 2), edge(c + 2)}, main(c + 1)}};
        }
        std::vector<Part> parts;
        for (std::size_t k = 0; k < 3; ++k) {
            parts.push_back({{corner(k), edge(k), Corner{At::inside, 0}}, main(k)});
            parts.push_back({{corner(k), Corner{At::inside, 0}, edge(k + 2)}, main(k)});
        }
        return parts;
    }
    [[nodiscard]] Point position(std::uint32_t f, const Corner& corner) const {
        if (corner.at == At::corner) return mesh_.points[mesh_.triangles[f][corner.k]];
        if (corner.at == At::edge) return *place_[sides_.edge(f, corner.k)];
        return corner_in(f);
    }
    // Where the three sides of a facet's corners meet, as planes through its corners and creases; else amid its creases.
    [[nodiscard]] Point corner_in(std::uint32_t f) const {
        Eigen::Matrix3d normals;
        Eigen::Vector3d heights;
        Point middle = Point::Zero();
        double longest = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t v = mesh_.triangles[f][k];
            const Vector& normal = sides_.sides()[main_[v]].normal;
            normals.row(static_cast<Eigen::Index>(k)) = normal.transpose();
            heights[static_cast<Eigen::Index>(k)] = normal.dot(mesh_.points[v]);
            middle += *place_[sides_.edge(f, k)] / 3;
            longest = std::max(longest, (mesh_.points[v] - mesh_.points[mesh_.triangles[f][(k + 1) % 3]]).norm());
        }
        if (std::abs(normals.determinant()) < 0.1) return middle;
        const Point meet = normals.inverse() * heights;
        return (meet - middle).norm() < std::min(most_, kMostHeight * longest) ? meet : middle;
    }
    [[nodiscard]] bool are_good(std::uint32_t f, const std::vector<Part>& parts) const {
        return std::ranges::all_of(parts, [&](const Part& part) {
            const Point a = position(f, part.corners[0]);
            const Vector normal = (position(f, part.corners[1]) - a).cross(position(f, part.corners[2]) - a);
            // Beside a corner that is on no side, or on both, it may look anywhere before it.
            const bool is_sure = part.side != kNone && std::ranges::none_of(part.corners, [&](const Corner& corner) {
                                     return corner.at == At::corner && main_[mesh_.triangles[f][corner.k]] == kNone;
                                 });
            if (is_sure) return normal.dot(sides_.sides()[part.side].normal) > kLeastTurn * normal.norm();
            return normal.dot(sides_.normal(f)) > 0;
        });
    }

    [[nodiscard]] SharpMesh assembled() const {
        SharpMesh sharp{mesh_, {}, error_};
        sharp.mesh.triangles.clear();
        std::vector<std::uint32_t> number(place_.size(), kNone);
        const auto add = [&](const Point& p, double error) {
            sharp.mesh.points.push_back(p);
            sharp.error.push_back(error);
            return static_cast<std::uint32_t>(sharp.mesh.points.size() - 1);
        };
        for (std::uint32_t e = 0; e < place_.size(); ++e) {
            const auto& ends = sides_.edges()[e].points;
            if (place_[e]) number[e] = add(*place_[e], std::max(error_[ends[0]], error_[ends[1]]));
        }
        for (std::uint32_t f = 0; f < mesh_.triangles.size(); ++f) {
            if (!splits(f)) {
                sharp.mesh.triangles.push_back(mesh_.triangles[f]);
                sharp.facet_of.push_back(f);
                continue;
            }
            std::uint32_t inside = kNone;
            for (const Part& part : parts_of(f)) {
                std::array<std::uint32_t, 3> triangle{};
                for (std::size_t k = 0; k < 3; ++k) {
                    const Corner& corner = part.corners[k];
                    if (corner.at == At::corner) triangle[k] = mesh_.triangles[f][corner.k];
                    if (corner.at == At::edge) triangle[k] = number[sides_.edge(f, corner.k)];
                    if (corner.at != At::inside) continue;
                    if (inside == kNone) inside = add(corner_in(f), error_[mesh_.triangles[f][0]]);
                    triangle[k] = inside;
                }
                sharp.mesh.triangles.push_back(triangle);
                sharp.facet_of.push_back(f);
            }
        }
        return sharp;
    }

    const TriangleMesh& mesh_;
    const std::vector<double>& error_;
    double most_;
    std::vector<std::uint8_t> apart_;
    FacetSides sides_;
    std::vector<std::uint32_t> main_;
    std::map<std::uint32_t, std::optional<LocalSpline>> splines_;
    std::vector<std::optional<Point>> place_;  // by edge
};

}  // namespace

SharpMesh sharpened(const TriangleMesh& mesh, const std::vector<double>& error, const std::vector<std::uint8_t>& flat, double most) {
    return Sharpening(mesh, error, flat, most).run();
}

}  // namespace palpate
