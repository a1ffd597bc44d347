#include "sim/objects/internal/placed_part.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

namespace palpate {

Nearest PlacedPart::nearest_to(const Point& p) const {
    const Point local = pose.to_local(p);
    Nearest n = std::visit([&](const auto& s) { return nearest(s, local); }, primitive);
    n.outward = pose.rotation * n.outward;
    return n;
}

Box PlacedPart::bounds() const {
    Vector half;
    for (int axis = 0; axis < 3; ++axis) half[axis] = support(primitive, pose.rotation.row(axis).transpose());
    return {pose.translation - half, pose.translation + half};  // every primitive is symmetric about its centre
}

Ray PlacedPart::to_local(const Ray& ray) const {
    return {pose.to_local(ray.origin), pose.rotation.transpose() * ray.direction, ray.length};
}

std::optional<double> PlacedPart::first_hit(const Ray& ray) const { return palpate::first_hit(primitive, to_local(ray), tolerance); }

void PlacedPart::append_crossings(const Ray& ray, std::vector<double>& out) const {
    palpate::append_crossings(primitive, to_local(ray), tolerance, out);
}

namespace {

struct Pair {
    Point on_b = Point::Zero();
    double gap = 0.0;  // mm
};

Point projected(const PlacedPart& part, const Point& p) {
    const Nearest n = part.nearest_to(p);
    return p - n.distance * n.outward;
}

// Ends when a round gains less than `precision` (mm), or at a gap of 0 or less: a point of one solid is in the other.
Pair alternate(const PlacedPart& a, const PlacedPart& b, Pair pair, int max_rounds, double precision) {
    for (int round = 0; round < max_rounds; ++round) {
        const Nearest to_a = a.nearest_to(pair.on_b);
        if (to_a.distance <= precision) return {pair.on_b, 0.0};
        const Point on_a = pair.on_b - to_a.distance * to_a.outward;
        const Nearest to_b = b.nearest_to(on_a);
        if (to_b.distance <= precision) return {pair.on_b, 0.0};
        const double gained = pair.gap - to_b.distance;
        pair = {on_a - to_b.distance * to_b.outward, to_b.distance};
        if (gained <= precision) break;
    }
    return pair;
}

}  // namespace

double smallest_gap(const PlacedPart& a, const PlacedPart& b) {
    constexpr int kLattice = 13;          // points per axis
    constexpr int kCoarseRounds = 30;     // from every start
    constexpr int kPolished = 16;         // starts that go on
    constexpr int kFineRounds = 200'000;  // enough for a gap of 1e-4 of the radius of curvature: each round removes about that share
    constexpr double kPrecision = 1e-15;  // of the parts' size

    const Box box = a.bounds();
    const double size = std::max(box.diagonal(), b.bounds().diagonal());
    std::vector<Pair> pairs;
    for (int i = 0; i < kLattice * kLattice * kLattice; ++i) {
        const Eigen::Vector3i index(i % kLattice, i / kLattice % kLattice, i / kLattice / kLattice);
        const Vector step = index.cast<double>();
        const Point on_a = projected(a, box.min + step.cwiseProduct(box.max - box.min) / (kLattice - 1));
        const Nearest to_b = b.nearest_to(on_a);
        if (to_b.distance <= 0.0) return to_b.distance;
        const Pair start{on_a - to_b.distance * to_b.outward, to_b.distance};
        pairs.push_back(alternate(a, b, start, kCoarseRounds, kPrecision * size));
        if (pairs.back().gap <= 0.0) return 0.0;
    }
    std::ranges::sort(pairs, {}, &Pair::gap);
    if (pairs.size() > kPolished) pairs.resize(kPolished);
    double least = std::numeric_limits<double>::infinity();
    for (const Pair& pair : pairs) least = std::min(least, alternate(a, b, pair, kFineRounds, kPrecision * size).gap);
    constexpr double kTouching = 1e-9;  // of the parts' size: what this function cannot tell from 0
    return least <= kTouching * size ? 0.0 : least;
}

}  // namespace palpate
