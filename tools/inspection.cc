#include "tools/inspection.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/facet_places.h"
#include "tools/formats/mesh_formats.h"
#include "tools/part_result.h"

namespace palpate {
namespace {

constexpr std::size_t kUnknowns = 6;
constexpr int kMostSteps = 200;
// Of the part's size: a step that moves nothing farther is the last.
constexpr double kSettled = 1e-12;
// So many steps that make the squares hardly less are enough.
constexpr int kInVain = 5;
constexpr double kBetter = 1 - 1e-6;
// Of the size: nearer to the reference than that, which way it lies is rounding.
constexpr double kOnIt = 1e-9;

double signed_distance(const HiddenObject& reference, const Point& p) {
    const double distance = reference.distance(p);
    return reference.contains(p) ? -distance : distance;
}

double quantile(const std::vector<double>& ascending, double share) {
    const double place = share * static_cast<double>(ascending.size() - 1);
    return ascending[static_cast<std::size_t>(std::ceil(place))];
}

// One step: of the turn about `centre` and the shift that the distances and their slopes ask for.
std::optional<RigidMotion> step(const HiddenObject& reference, std::span<const Point> points, std::span<const Vector> normals,
                                const Point& centre, double size) {
    using Six = Eigen::Matrix<double, kUnknowns, 1>;
    Eigen::Matrix<double, kUnknowns, kUnknowns> normal = Eigen::Matrix<double, kUnknowns, kUnknowns>::Zero();
    Six right = Six::Zero();
    for (std::size_t k = 0; k < points.size(); ++k) {
        const Point& p = points[k];
        const Point nearest = reference.closest_point(p);
        const double distance = signed_distance(reference, p);
        const Vector way = p - nearest;
        // Outwards, whichever side it is on.
        const Vector up = std::abs(distance) > kOnIt * size ? Vector(way / distance) : normals[k];
        Six slope;
        slope << (p - centre).cross(up) / size, up;
        normal += slope * slope.transpose();
        right -= distance * slope;
    }
    // What nothing holds, a turn of a ball or a shift along a prism, stays as it is.
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, kUnknowns, kUnknowns>> solver(normal);
    if (solver.info() != Eigen::Success) return std::nullopt;
    Six unknown = Six::Zero();
    const double strongest = solver.eigenvalues().maxCoeff();
    for (int k = 0; k < static_cast<int>(kUnknowns); ++k) {
        if (solver.eigenvalues()[k] < 1e-9 * strongest) continue;
        const Six v = solver.eigenvectors().col(k);
        unknown += v.dot(right) / solver.eigenvalues()[k] * v;
    }
    const Vector turn = unknown.head<3>() / size;
    RigidMotion motion;
    if (turn.norm() > 0) motion.rotation = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    motion.translation = centre + unknown.tail<3>() - motion.rotation * centre;
    return motion;
}

}  // namespace

double DeviationSummary::largest() const { return std::max(std::abs(lowest), std::abs(highest)); }

DeviationSummary summarize(std::span<const double> deviations) {
    DeviationSummary sum;
    sum.count = deviations.size();
    std::vector<double> sizes;
    double squares = 0;
    sum.lowest = sum.highest = deviations.front();
    for (const double d : deviations) {
        sum.mean += d / static_cast<double>(sum.count);
        squares += d * d;
        sum.lowest = std::min(sum.lowest, d);
        sum.highest = std::max(sum.highest, d);
        sizes.push_back(std::abs(d));
    }
    sum.rms = std::sqrt(squares / static_cast<double>(sum.count));
    std::ranges::sort(sizes);
    sum.p95 = quantile(sizes, 0.95);
    sum.p99 = quantile(sizes, 0.99);
    return sum;
}

std::vector<std::size_t> histogram(std::span<const double> deviations, double limit, std::size_t bins) {
    std::vector<std::size_t> counts(bins, 0);
    for (const double d : deviations) {
        const double place = limit > 0 ? (d + limit) / (2 * limit) * static_cast<double>(bins) : static_cast<double>(bins) / 2;
        ++counts[static_cast<std::size_t>(std::clamp(place, 0.0, static_cast<double>(bins - 1)))];
    }
    return counts;
}

Inspected inspected_part(const TriangleMesh& mesh, const std::string& ply) {
    const std::vector<PartTag> tags = facet_tags_in(ply);
    Inspected part;
    part.facets.points = mesh.points;
    std::vector<bool> is_measured(mesh.points.size(), false);
    for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
        if (!tags.empty() && tags.at(k) != PartTag::tip) continue;
        part.facets.triangles.push_back(mesh.triangles[k]);
        for (const std::uint32_t corner : mesh.triangles[k]) is_measured[corner] = true;
    }
    const std::vector<Vector> normals = vertex_normals(part.facets);
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
        if (!is_measured[v]) continue;
        part.samples.push_back(mesh.points[v]);
        part.normals.push_back(normals[v]);
    }
    return part;
}

double RigidMotion::degrees() const { return Eigen::AngleAxisd(rotation).angle() * 180 / std::numbers::pi; }

std::optional<RigidMotion> best_fit(const HiddenObject& reference, const Inspected& part) {
    if (part.samples.size() < kUnknowns) return std::nullopt;
    std::vector<Point> moved = part.samples;
    std::vector<Vector> normals = part.normals;
    RigidMotion whole;
    RigidMotion best;
    double least = std::numeric_limits<double>::infinity();
    int in_vain = 0;
    for (int k = 0; k < kMostSteps; ++k) {
        double squares = 0;
        for (const Point& p : moved) squares += std::pow(reference.distance(p), 2);
        // The facets of a reference have the last steps go to and fro, or slide along what hardly holds.
        in_vain = squares < kBetter * least ? 0 : in_vain + 1;
        if (squares < least) {
            least = squares;
            best = whole;
        }
        if (in_vain == kInVain) return best;
        Point centre = Point::Zero();
        for (const Point& p : moved) centre += p / static_cast<double>(moved.size());
        double size = 0;
        for (const Point& p : moved) size = std::max(size, (p - centre).norm());
        const auto motion = step(reference, moved, normals, centre, size);
        if (!motion) return std::nullopt;
        double farthest = 0;
        for (Point& p : moved) {
            const Point there = (*motion)(p);
            farthest = std::max(farthest, (there - p).norm());
            p = there;
        }
        for (Vector& normal : normals) normal = motion->rotation * normal;
        whole = {motion->rotation * whole.rotation, (*motion)(whole.translation)};
        if (!whole.translation.allFinite()) return std::nullopt;
        if (farthest <= kSettled * size) return whole;
    }
    return std::nullopt;
}

Deviations deviations_from(const HiddenObject& reference, const Inspected& part, const RigidMotion& motion, std::size_t facet_points) {
    Deviations found;
    for (const Point& p : part.samples) found.at_samples.push_back(signed_distance(reference, motion(p)));
    for_each_facet(part.facets, facet_points, [&](const FacetPlaces& facet) {
        for (const Point& p : facet.places) found.at_facets.push_back(signed_distance(reference, motion(p)));
    });
    std::ranges::sort(found.at_facets);
    return found;
}

}  // namespace palpate
