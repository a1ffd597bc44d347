#include "planner/curved/curved_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "planner/curved/internal/blend.h"
#include "planner/curved/internal/crossing_parts.h"
#include "planner/curved/internal/facet_sides.h"
#include "planner/curved/internal/sharpen.h"
#include "planner/curved/internal/subdivision.h"

// Notation. A *facet* is one of the mesh that is given, its *parts* are those of the result. A *side* is the facets around a point that go
// on into each other without a crease (internal/facet_sides.h); s its spline (internal/local_spline.h). With shares l (barycentric
// coordinates) of the corners of a facet, F = Σ lᵢ³ sᵢ / Σ lᵢ³ is its blend (internal/blend.h), and n = Σ lᵢ nᵢ the direction of its
// normals. A point of the result is where F is zero on the line from Σ lᵢ xᵢ along n. On an edge lᵢ = 0 for the corner beyond: the point
// depends on what both facets have, and is the same for them.
namespace palpate {
namespace {

constexpr int kRings = 3;
constexpr std::size_t kMostSites = LocalSpline::kMostSites;
// Of the longest edge of a facet or of an edge: how far a point goes at most. A sphere's goes so far where the balls of its facets have 0.9
// times its radius; of an equilateral facet's circumradius it is half.
constexpr double kMostOff = 0.3;
// Rounds of flattening facets that cross others. One that is not enough is not expected.
constexpr int kRounds = 8;

// How the surface's distance in places follows from surprises: calibrated, planner/curved/README.md, "Predicted uncertainty".
// Between touches the surface is off by about a surprise times kOfSurprise · (kRough / rate)^kPower, where the rate is that by which the
// surprise grows when those around are left out, too. It is about 2 where touches are too coarse for the surface's detail, 16 where it is
// smooth to them.
constexpr double kOfSurprise = 2.2;
constexpr double kRough = 2.0;
constexpr double kPower = 1.25;
constexpr double kMostRate = 16.0;

double bound_of_flat(const FacetSides& sides, const TriangleMesh& mesh, std::uint32_t facet) {
    double most = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const auto& a = sides.sides()[sides.side(facet, k)];
        const auto& b = sides.sides()[sides.side(facet, (k + 1) % 3)];
        most = std::max(most, std::abs((a.normal - b.normal).dot(mesh.points[b.point] - mesh.points[a.point])));
    }
    return most;
}

class Curving {
public:
    Curving(const TouchedMesh& touched, const CurvedOptions& options, std::uint32_t segments)
        : touched_(touched),
          mesh_(touched.mesh),
          options_(options),
          sides_(touched.mesh, touched.is_flat),
          parts_(touched.mesh, sides_, segments),
          is_flat_(touched.is_flat) {
        is_flat_.resize(mesh_.triangles.size(), 0);
    }

    CurvedSurface run() {
        fit();
        const std::size_t n = parts_.points();
        surface_.mesh.points.resize(n);
        surface_.normals.assign(n, Vector::Zero());
        surface_.curvature.assign(n, {0, 0});
        surface_.uncertainty.assign(n, 0);
        surface_.tags.assign(n, CurvedTag::smooth);
        for (std::uint32_t f = 0; f < mesh_.triangles.size(); ++f) {
            for (std::size_t k = 0; k < 3; ++k) {
                if (!surfaces_[sides_.side(f, k)].spline) is_flat_[f] = 1;
            }
        }
        place_touches();
        for (std::uint32_t e = 0; e < sides_.edges().size(); ++e) place_edge(e);
        for (std::uint32_t f = 0; f < mesh_.triangles.size(); ++f) place_inside(f);
        for (std::uint32_t f = 0; f < mesh_.triangles.size(); ++f) {
            parts_.append_parts(f, surface_.mesh.triangles);
            surface_.facet_of.resize(surface_.mesh.triangles.size(), f);
        }
        flatten_crossing();
        return std::move(surface_);
    }

private:
    [[nodiscard]] double error_of(std::uint32_t point) const { return touched_.error.empty() ? 0.0 : touched_.error[point]; }
    // mm: as a spline takes it.
    [[nodiscard]] double finite_error(std::uint32_t point) const {
        const double error = error_of(point);
        return std::isfinite(error) ? error : options_.epsilon;
    }

    void fit() {
        surfaces_.resize(sides_.sides().size());
        std::vector<LocalSpline::Site> sites;
        for (std::uint32_t s = 0; s < surfaces_.size(); ++s) {
            const auto& side = sides_.sides()[s];
            if (!touched_.is_flat.empty() && touched_.is_flat[sides_.facets(side).front()] != 0) continue;
            sites.clear();
            std::size_t near = sides_.rings(s, 1, kMostSites).size();
            const std::size_t with_normal = sides_.rings(s, kRings - 1, kMostSites).size();
            std::size_t taken = 0;
            for (const std::uint32_t other : sides_.rings(s, kRings, kMostSites)) {
                const auto& around = sides_.sides()[other];
                if (around.normal.isZero()) {
                    if (&around != &side && sites.size() < near) --near;
                    continue;
                }
                sites.push_back({mesh_.points[around.point], around.normal, finite_error(around.point), taken++ < with_normal});
            }
            // Its circumradius if its facets were equilateral.
            if (!side.normal.isZero())
                surfaces_[s].spline = LocalSpline::fit(sites, near, side.spacing / std::sqrt(3.0), LocalSpline::Trend::quadric);
        }
        for (std::uint32_t s = 0; s < surfaces_.size(); ++s) {
            double squares = 0;
            double far_squares = 0;
            double count = 0;
            for (const std::uint32_t other : sides_.rings(s, 1, kMostSites)) {
                const auto& spline = surfaces_[other].spline;
                if (!spline || !std::isfinite(spline->far_surprise())) continue;
                squares += std::pow(spline->surprise(), 2);
                far_squares += std::pow(spline->far_surprise(), 2);
                ++count;
            }
            if (count == 0) continue;
            surfaces_[s].surprise = std::sqrt(squares / count);
            surfaces_[s].far_surprise = std::sqrt(far_squares / count);
        }
    }

    [[nodiscard]] Share share(std::uint32_t side, double amount) const { return {&sides_.sides()[side], &surfaces_[side], amount}; }
    [[nodiscard]] double most_off(std::uint32_t facet) const {
        double longest = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            longest =
                std::max(longest, (mesh_.points[mesh_.triangles[facet][k]] - mesh_.points[mesh_.triangles[facet][(k + 1) % 3]]).norm());
        }
        return std::min(kMostOff * longest, options_.epsilon);
    }

    void set(std::uint32_t at, const BlendedPlace& place, double uncertainty, CurvedTag tag) {
        surface_.mesh.points[at] = place.point;
        surface_.normals[at] = place.normal;
        surface_.curvature[at] = place.curvature;
        surface_.uncertainty[at] = uncertainty;
        surface_.tags[at] = tag;
    }

    // mm: how far the surface is from a part whose edges are `length` long: κ l²/8 amid its edges, κ l²/6 at its centre.
    static double chord(const std::array<double, 2>& curvature, double length) {
        return std::max(std::abs(curvature[0]), std::abs(curvature[1])) * length * length / 7;
    }
    [[nodiscard]] double uncertainty(const std::array<Share, 3>& shares, const BlendedPlace& place) const {
        double squares = 0;
        double far_squares = 0;
        double error = 0;
        double products = 0;
        double spacing = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const Share& one = shares[k];
            if (!(one.share > 0)) continue;
            squares += one.share * std::pow(one.surface->surprise, 2);
            far_squares += one.share * std::pow(one.surface->far_surprise, 2);
            error += one.share * error_of(one.side->point);
            spacing += one.share * one.side->spacing;
            products += one.share * shares[(k + 1) % 3].share;
        }
        const double far = std::min(1.0, 4 * products);
        const double rate = squares > 0 ? std::clamp(std::sqrt(far_squares / squares), 1.0, kMostRate) : kMostRate;
        const double between = kOfSurprise * std::sqrt(squares) * std::pow(kRough / rate, kPower) * far;
        return std::hypot(error, between) + chord(place.curvature, spacing / parts_.segments());
    }

    void place_touches() {
        // Sides by point.
        std::vector<std::vector<std::uint32_t>> at(mesh_.points.size());
        for (std::uint32_t s = 0; s < surfaces_.size(); ++s) at[sides_.sides()[s].point].push_back(s);
        for (std::uint32_t v = 0; v < mesh_.points.size(); ++v) {
            BlendedPlace sum{mesh_.points[v], Vector::Zero(), {0, 0}};
            double uncertain = error_of(v);
            for (const std::uint32_t s : at[v]) {
                const std::array<Share, 3> shares{share(s, 1.0), Share{}, Share{}};
                const Blend blend(shares);
                if (!blend.is_valid()) {
                    sum.normal += sides_.sides()[s].normal;
                    continue;
                }
                BlendedPlace place = blend.at(mesh_.points[v]);
                if (at[v].size() == 1 && error_of(v) > 0) {
                    // As far as the touch may err.
                    if (const auto moved =
                            blend.project(mesh_.points[v], std::min(finite_error(v), most_off(sides_.facets(sides_.sides()[s]).front())))) {
                        place = *moved;
                        sum.point = place.point;
                    }
                }
                sum.normal += place.normal;
                for (std::size_t k = 0; k < 2; ++k) sum.curvature[k] += place.curvature[k] / static_cast<double>(at[v].size());
                uncertain = std::max(uncertain, uncertainty(shares, place));
            }
            const double norm = sum.normal.norm();
            sum.normal = norm > 1e-9 ? Vector(sum.normal / norm) : Vector::UnitZ();
            const CurvedTag tag = at[v].size() > 2 ? CurvedTag::corner : at[v].size() == 2 ? CurvedTag::crease : CurvedTag::smooth;
            set(v, sum, uncertain, tag);
        }
    }

    [[nodiscard]] std::array<Share, 3> shares_on(const MeshEdge& edge, std::size_t which, double towards) const {
        const auto& corners = edge.corners.at(which);
        const std::uint32_t f = edge.facets.at(which);
        return {share(sides_.side(f, corners[0]), 1 - towards), share(sides_.side(f, corners[1]), towards), Share{}};
    }
    void place_edge(std::uint32_t e) {
        const MeshEdge& edge = sides_.edges()[e];
        const Point& a = mesh_.points[edge.points[0]];
        const Point& b = mesh_.points[edge.points[1]];
        const bool stays = is_flat_[edge.facets[0]] != 0 || (edge.count == 2 && is_flat_[edge.facets[1]] != 0) || edge.count > 2;
        const double most = std::min(kMostOff * (b - a).norm(), options_.epsilon);
        for (std::uint32_t k = 1; k < parts_.segments(); ++k) {
            const double towards = static_cast<double>(k) / parts_.segments();
            const Point from = (1 - towards) * a + towards * b;
            const std::uint32_t at = parts_.on_edge(e, k);
            if (stays) {
                set_flat(at, from, edge, towards);
                continue;
            }
            const std::array<Share, 3> shares = shares_on(edge, 0, towards);
            const Blend blend(shares);
            if (edge.is_smooth || edge.count == 1) {
                const auto place = blend.is_valid() ? blend.project(from, most) : std::nullopt;
                place ? set(at, *place, uncertainty(shares, *place), edge.is_smooth ? CurvedTag::smooth : CurvedTag::crease)
                      : set_flat(at, from, edge, towards);
                continue;
            }
            const std::array<Share, 3> beyond = shares_on(edge, 1, towards);
            const Blend other(beyond);
            std::optional<Point> point;
            if (blend.is_valid() && other.is_valid()) {
                point = crease_place(blend, other, from, most);
                if (!point) {
                    // A crease that ends here.
                    const auto here = blend.project(from, most);
                    const auto beyond_it = other.project(from, most);
                    if (here && beyond_it) point = (here->point + beyond_it->point) / 2;
                }
            }
            if (!point) {
                set_flat(at, from, edge, towards);
                surface_.tags[at] = CurvedTag::crease;
                continue;
            }
            BlendedPlace one = blend.at(*point);
            const BlendedPlace two = other.at(*point);
            const double uncertain = std::max(uncertainty(shares, one), uncertainty(beyond, two));
            one.normal = (one.normal + two.normal).normalized();
            for (std::size_t i = 0; i < 2; ++i) one.curvature[i] = (one.curvature[i] + two.curvature[i]) / 2;
            set(at, one, uncertain, CurvedTag::crease);
        }
    }

    void place_inside(std::uint32_t f) {
        const double most = most_off(f);
        for (std::uint32_t j = 1; j + 1 < parts_.segments(); ++j) {
            for (std::uint32_t i = 1; i + j < parts_.segments(); ++i) {
                const auto l = parts_.shares(i, j);
                const Point from = on_facet(f, l);
                const std::array<Share, 3> shares{share(sides_.side(f, 0), l[0]), share(sides_.side(f, 1), l[1]),
                                                  share(sides_.side(f, 2), l[2])};
                const std::uint32_t at = parts_.at(f, i, j);
                const Blend blend(shares);
                const auto place = is_flat_[f] == 0 && blend.is_valid() ? blend.project(from, most) : std::nullopt;
                place ? set(at, *place, uncertainty(shares, *place), CurvedTag::smooth) : set_flat(at, from, f, l);
            }
        }
    }
    [[nodiscard]] Point on_facet(std::uint32_t f, const std::array<double, 3>& l) const {
        const auto& [a, b, c] = mesh_.triangles[f];
        return l[0] * mesh_.points[a] + l[1] * mesh_.points[b] + l[2] * mesh_.points[c];
    }

    void set_flat(std::uint32_t at, const Point& p, std::uint32_t f, const std::array<double, 3>& l) {
        double error = 0;
        double products = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            error += l[k] * error_of(mesh_.triangles[f][k]);
            products += l[k] * l[(k + 1) % 3];
        }
        const double far = std::min(1.0, 4 * products);
        set(at, {p, sides_.normal(f).isZero() ? Vector(Vector::UnitZ()) : sides_.normal(f), {0, 0}},
            error + bound_of_flat(sides_, mesh_, f) * far / 2, CurvedTag::flat);
    }
    void set_flat(std::uint32_t at, const Point& p, const MeshEdge& edge, double towards) {
        std::array<double, 3> l{0, 0, 0};
        l.at(edge.corners[0][0]) = 1 - towards;
        l.at(edge.corners[0][1]) = towards;
        set_flat(at, p, edge.facets[0], l);
        if (edge.count < 2) return;
        const Vector sum = sides_.normal(edge.facets[0]) + sides_.normal(edge.facets[1]);
        if (sum.norm() > 1e-9) surface_.normals[at] = sum.normalized();
    }

    void flatten_crossing() {
        auto pairs = crossing_pairs(surface_.mesh);
        for (int round = 0; round < kRounds && !pairs.empty(); ++round) {
            // Facets that change, with those beyond their edges.
            std::vector<std::uint32_t> changed;
            for (const auto& [part, other] : pairs) {
                for (const std::uint32_t p : {part, other}) {
                    const std::uint32_t f = surface_.facet_of[p];
                    if (is_flat_[f] != 0) continue;
                    is_flat_[f] = 1;
                    surface_.crossing.push_back(f);
                    place_inside(f);
                    for (std::size_t k = 0; k < 3; ++k) {
                        const std::uint32_t e = sides_.edge(f, k);
                        place_edge(e);
                        for (const std::uint32_t g : sides_.edges()[e].facets) {
                            if (g != kNoFacet) changed.push_back(g);
                        }
                    }
                }
            }
            std::ranges::sort(changed);
            changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
            const std::uint32_t squared = parts_.segments() * parts_.segments();
            std::vector<std::uint32_t> parts;
            for (const std::uint32_t f : changed) {
                for (std::uint32_t k = 0; k < squared; ++k) parts.push_back(f * squared + k);
            }
            pairs = crossing_pairs(surface_.mesh, parts);
        }
        std::ranges::sort(surface_.crossing);
    }

    const TouchedMesh& touched_;
    const TriangleMesh& mesh_;
    const CurvedOptions& options_;
    FacetSides sides_;
    Subdivision parts_;
    std::vector<std::uint8_t> is_flat_;
    std::vector<SideSurface> surfaces_;
    CurvedSurface surface_;
};

void check(const TouchedMesh& touched, const CurvedOptions& options) {
    const auto require = [](bool holds, const char* what) {
        if (!holds) throw std::invalid_argument(what);
    };
    const std::size_t points = touched.mesh.points.size();
    for (const auto& triangle : touched.mesh.triangles) {
        for (const std::uint32_t v : triangle) require(v < points, "a facet names a point that the mesh does not have");
    }
    for (const Point& p : touched.mesh.points) require(p.allFinite(), "a point of the mesh is not finite");
    require(touched.error.empty() || touched.error.size() == points, "error is not as long as the mesh's points");
    for (const double e : touched.error) require(e >= 0, "an error is negative or no number");
    require(touched.is_flat.empty() || touched.is_flat.size() == touched.mesh.triangles.size(),
            "is_flat is not as long as the mesh's triangles");
    require(options.epsilon > 0 && std::isfinite(options.epsilon), "epsilon is not positive and finite");
    require(options.segments >= 1 && options.segments <= 64, "segments are not from 1 to 64");
}

}  // namespace

CurvedSurface curve(const TouchedMesh& touched, const CurvedOptions& options) {
    check(touched, options);
    std::vector<double> error = touched.error;
    error.resize(touched.mesh.points.size(), 0.0);
    SharpMesh sharp = sharpened(touched.mesh, error, touched.is_flat, options.epsilon);
    TouchedMesh split{std::move(sharp.mesh), std::move(sharp.error), {}};
    if (!touched.is_flat.empty()) {
        for (const std::uint32_t f : sharp.facet_of) split.is_flat.push_back(touched.is_flat[f]);
    }
    auto segments = static_cast<std::size_t>(options.segments);
    while (segments > 1 && segments * segments * split.mesh.triangles.size() > options.largest_facets) --segments;
    CurvedSurface surface = Curving(split, options, static_cast<std::uint32_t>(segments)).run();
    for (std::uint32_t& f : surface.facet_of) f = sharp.facet_of[f];
    for (std::uint32_t& f : surface.crossing) f = sharp.facet_of[f];
    surface.crossing.erase(std::unique(surface.crossing.begin(), surface.crossing.end()), surface.crossing.end());
    return surface;
}

}  // namespace palpate
