// How far a result lies from a reference: a mesh that somebody else made of the same part, a CAD model's or an earlier one's.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "planner/geometry.h"
#include "sim/objects/hidden_object.h"

namespace palpate {

struct Deviations {
    std::vector<double> at_samples;  // mm, by sample: outside the reference is positive
    std::vector<double> at_facets;   // mm, of places of the facets, evenly by area; ascending
};

struct DeviationSummary {
    std::size_t count = 0;
    double mean = 0.0;  // mm, signed
    double rms = 0.0;
    double lowest = 0.0;
    double highest = 0.0;
    double p95 = 0.0;  // of 95 in 100 no more, whichever way
    double p99 = 0.0;

    [[nodiscard]] double largest() const;  // whichever way
};
// REQUIRES: not empty.
[[nodiscard]] DeviationSummary summarize(std::span<const double> deviations);

// How often deviations lie in each of so many equal parts of [-limit, limit].
[[nodiscard]] std::vector<std::size_t> histogram(std::span<const double> deviations, double limit, std::size_t bins);

// What is compared: corners and triangles of a result.
struct Inspected {
    std::vector<Point> samples;
    std::vector<Vector> normals;  // of the samples: unit, outwards
    TriangleMesh facets;
};
// A session's mesh; of a part that a tool has touched what it measured alone: neither fixtures nor shadows.
[[nodiscard]] Inspected inspected_part(const TriangleMesh& mesh, const std::string& ply);

// Of a rigid motion: x becomes rotation · x + translation.
struct RigidMotion {
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    Vector translation = Vector::Zero();

    [[nodiscard]] Point operator()(const Point& p) const { return rotation * p + translation; }
    [[nodiscard]] double degrees() const;  // that it turns by
};

// The motion of the samples that makes the squares of their distances to the reference least, by Gauss and Newton on the distance itself;
// from where they are, so a part that lies far off or turned ends elsewhere. Nothing if there are fewer than six, or it does not settle.
[[nodiscard]] std::optional<RigidMotion> best_fit(const HiddenObject& reference, const Inspected& part);

// `facet_points`: about so many places of the facets are looked at.
[[nodiscard]] Deviations deviations_from(const HiddenObject& reference, const Inspected& part, const RigidMotion& motion,
                                         std::size_t facet_points);

}  // namespace palpate
