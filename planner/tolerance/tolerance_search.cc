#include "planner/tolerance/tolerance_search.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "planner/curved/curved_surface.h"
#include "planner/random.h"

namespace palpate {
namespace {

// Of edges, while touches are looked for: a point of these is near to the middle of every ball.
constexpr int kSegments = 3;
// Of a ball's radius: touches keep that from samples, so that these stay spread evenly. Places near to each other are touched once.
constexpr double kSpread = 0.7;
// The same of the very centre of a ball, which is touched where that did not help.
constexpr double kSpreadOfCentre = 0.9;
// Of a ball's radius: so near to a touch that was in vain it is not tried again.
constexpr double kInVain = 0.5;
// Surprises that are looked back at; fewer than the least say nothing.
constexpr std::size_t kRemembered = 100;
constexpr std::size_t kLeast = 20;
constexpr double kShare = 0.95;  // of them are to be within what is stated
constexpr double kLeastScale = 0.15;
constexpr double kGreatestScale = 4.0;
// Of the tolerance: what is told apart of what was stated.
constexpr std::array<double, 5> kStatedUpTo = {0.25, 0.5, 1, 2, std::numeric_limits<double>::infinity()};

double area(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& t) {
    return (mesh.points[t[1]] - mesh.points[t[0]]).cross(mesh.points[t[2]] - mesh.points[t[0]]).norm() / 2;
}

}  // namespace

struct ToleranceSearch::FineSurface {
    CurvedSurface surface;
    std::vector<double> worst;          // per triangle of Ŝ, mm
    std::vector<std::uint32_t> middle;  // per triangle of Ŝ: the point nearest to its ball's centre

    [[nodiscard]] Place place(const SampledSurface& of, std::uint32_t facet, std::uint32_t point) const {
        Place place{surface.mesh.points[point], surface.normals[point], surface.uncertainty[point], kSpread * of.ball_radii[facet], {}};
        for (std::size_t k = 0; k < 3; ++k) place.samples.at(k) = of.sample_of[of.mesh.triangles[facet].at(k)];
        return place;
    }
};

ToleranceSearch::ToleranceSearch(const Options& options) : options_(options), random_(options.random_seed) {
    evidence_.tolerance = options.tolerance;
    double least = 0;
    for (std::size_t k = 0; k < kStatedUpTo.size(); ++k) {
        evidence_.stated.at(k).least = least;
        evidence_.stated.at(k).most = least = kStatedUpTo.at(k) * options.tolerance;
    }
}

void ToleranceSearch::compare(double off, double stated) {
    if (!(stated > 0)) return;
    StatedDeviation& as_stated = *std::ranges::find_if(evidence_.stated, [&](const StatedDeviation& s) { return stated <= s.most; });
    ++as_stated.touched;
    as_stated.within += off <= stated + options_.touch_error ? 1 : 0;
    as_stated.worst = std::max(as_stated.worst, off);
}

ToleranceSearch::FineSurface ToleranceSearch::curved(const SampledSurface& surface) const {
    const std::vector<double> errors(options_.touch_error > 0 ? surface.mesh.points.size() : 0, options_.touch_error);
    CurvedOptions options;
    options.epsilon = options_.epsilon;
    options.segments = kSegments;
    FineSurface fine{curve({surface.mesh, errors, surface.is_known}, options), {}, {}};
    fine.worst.resize(surface.mesh.triangles.size());
    fine.middle.resize(surface.mesh.triangles.size());
    std::vector<double> nearest(surface.mesh.triangles.size(), std::numeric_limits<double>::infinity());
    const TriangleMesh& mesh = fine.surface.mesh;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const std::uint32_t facet = fine.surface.facet_of[t];
        for (const std::uint32_t v : mesh.triangles[t]) {
            fine.worst[facet] = std::max(fine.worst[facet], fine.surface.uncertainty[v]);
            const double distance = (mesh.points[v] - surface.ball_centres[facet]).norm();
            if (distance >= nearest[facet]) continue;
            nearest[facet] = distance;
            fine.middle[facet] = v;
        }
    }
    return fine;
}

double ToleranceSearch::scale() const {
    if (surprises_.size() < kLeast) return 1;
    std::vector<double> sorted(surprises_.begin(), surprises_.end());
    const auto at = sorted.begin() + static_cast<std::ptrdiff_t>(kShare * static_cast<double>(sorted.size() - 1));
    std::nth_element(sorted.begin(), at, sorted.end());
    return std::clamp(*at, kLeastScale, kGreatestScale);
}

bool ToleranceSearch::is_near(const std::vector<Point>& points, const Place& place) {
    return std::ranges::any_of(points, [&](const Point& p) { return (p - place.at).norm() < kInVain / kSpread * place.spacing; });
}

ToleranceSearch::Place ToleranceSearch::centre(const SampledSurface& surface, std::uint32_t facet, Place place) const {
    const auto& [i, j, k] = surface.mesh.triangles[facet];
    const Point& a = surface.mesh.points[i];
    const Point& b = surface.mesh.points[j];
    const Point& c = surface.mesh.points[k];
    const Vector across = (b - a).cross(c - a);
    place.at = surface.ball_centres[facet];
    place.stated = 0;
    if (!(across.norm() > 0)) return place;
    place.normal = across.normalized();
    // Wherever S meets the dual edge, that is as far from the samples as the facet's circumradius at least.
    place.spacing = std::max(options_.spacing_min, kSpreadOfCentre * circumradius(a, b, c));
    return place;
}

std::vector<ToleranceSearch::Place> ToleranceSearch::places(const SampledSurface& surface) {
    evidence_.foretold = 0;
    evidence_.unmet_facets = 0;
    const FineSurface fine = curved(surface);
    const double scale = evidence_.scale = this->scale();
    expected_touches_ = 0;
    std::vector<Place> places;
    for (std::uint32_t f = 0; f < surface.mesh.triangles.size(); ++f) {
        if (!surface.is_known.empty() && surface.is_known[f] != 0) continue;
        if (!is_asked_for(fine.surface.mesh.points[fine.middle[f]])) continue;
        const double foretold = scale * fine.worst[f];
        evidence_.foretold = std::max(evidence_.foretold, foretold);
        if (!(foretold > options_.tolerance)) continue;
        // It goes with the cube of the spacing, and there are two facets to a sample.
        *expected_touches_ += std::max(1.0, std::pow(foretold / options_.tolerance, 2.0 / 3) - 1) / 2;
        Place place = fine.place(surface, f, fine.middle[f]);
        place.spacing = std::max(place.spacing, options_.spacing_min);
        if (surface.ball_radii[f] < options_.spacing_min) {
            ++evidence_.unmet_facets;
        } else if (!is_near(in_vain_, place)) {
            places.push_back(place);
        } else {
            std::ranges::sort(place.samples);
            if (centred_.contains(place.samples)) {
                ++evidence_.unmet_facets;
            } else {
                places.push_back(centre(surface, f, place));
            }
        }
    }
    if (surprises_.size() < kLeast && places.size() > kLeast) {
        // From everywhere.
        for (std::size_t k = 0; k < kLeast; ++k) places[k] = places[k * places.size() / kLeast];
        places.resize(kLeast);
    }
    for (const Place& place : places) {
        if (!(place.stated > 0)) centred_.insert(place.samples);
    }
    return places;
}

std::vector<ToleranceSearch::Place> ToleranceSearch::draw(const SampledSurface& surface, std::size_t count) {
    const FineSurface fine = curved(surface);
    const TriangleMesh& mesh = fine.surface.mesh;
    std::vector<double> below(mesh.triangles.size());
    double sum = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const std::uint32_t facet = fine.surface.facet_of[t];
        const bool is_known = !surface.is_known.empty() && surface.is_known[facet] != 0;
        if (!is_known && is_asked_for(mesh.points[mesh.triangles[t][0]])) sum += area(mesh, mesh.triangles[t]);
        below[t] = sum;
    }
    std::vector<Place> drawn;
    if (!(sum > 0)) return drawn;
    for (std::size_t k = 0; k < count; ++k) {
        const double at = sum * uniform(random_);
        const auto t = static_cast<std::size_t>(std::ranges::upper_bound(below, at) - below.begin());
        const auto& triangle = mesh.triangles[std::min(t, mesh.triangles.size() - 1)];
        drawn.push_back(fine.place(surface, fine.surface.facet_of[std::min(t, mesh.triangles.size() - 1)], triangle[random_() % 3]));
        drawn.back().spacing = options_.spacing_min;
    }
    return drawn;
}

void ToleranceSearch::note(const Place& place, const std::optional<Point>& met, bool inserted) {
    ++evidence_.touched;
    // What is in the way may be gone, or passed, another time.
    if (!met && !inserted && !is_near(barred_, place)) {
        barred_.push_back(place.at);
    } else if (!inserted) {
        in_vain_.push_back(place.at);
    }
    if (!met || !(place.stated > 0)) return;
    const double off = std::abs((*met - place.at).dot(place.normal));
    compare(off, scale() * place.stated);
    surprises_.push_back(off / place.stated);
    if (surprises_.size() > kRemembered) surprises_.pop_front();
}

void ToleranceSearch::note_audit(const Place& place, const std::optional<Point>& met) {
    if (!met) {
        ++evidence_.barred;
        return;
    }
    const double off = std::abs((*met - place.at).dot(place.normal));
    ++evidence_.audited;
    evidence_.beyond += off > options_.tolerance + options_.touch_error ? 1 : 0;
    evidence_.worst = std::max(evidence_.worst, off);
    compare(off, scale() * place.stated);
}

}  // namespace palpate
