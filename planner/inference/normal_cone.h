// The normals that a touched point can still have, given a bound on the reach (planner/DESIGN.md, "Inference").
//
// Notation:
//   a     a touched point of S, n its outward unit normal; r a bound: rch(S) >= r, so that both open balls of radius r
//         that touch S at a miss S: no touched point lies in B(a + r n, r) or in B(a - r n, r)
//   b     another touched point, d = |b - a|, u = (b - a)/d
//   slab  the first ball says d² >= 2 r d <u, n>, the second the same for -n, so |<u, n>| <= d / 2r
// Every b so leaves a slab of normals, and the slabs of a few neighbours of a leave a small cone around n and its mirror
// image; the way from which a was touched tells them apart. That is sharper than Lemma 1.5: a ring of neighbours at distance
// d leaves an angle of about 1.15 d / 2r, a triangle of them 1.7 d / 2r or more by the lemma.
//
// Numerics: the cone is kept as a polygon in a plane that it crosses, cut by straight lines that leave no more than
// the slab does; `margin` (mm) is what touched points may be wrong by, and widens every slab.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "planner/geometry.h"

namespace palpate {

class NormalCone {
public:
    // Unit vectors; every normal that is possible lies in the cone that they span. Empty as long as nothing is known.
    [[nodiscard]] std::span<const Vector> extremes() const { return {extremes_.data(), count_}; }
    [[nodiscard]] bool is_known() const { return count_ > 0; }
    // A unit vector in the middle of the cone. REQUIRES: is_known().
    [[nodiscard]] Vector axis() const;

    // Starts with two neighbours of a, at `b` and `c` from it. `outwards` points from a to where the probe that touched
    // it came from. False if too many normals are left to tell the two sides apart.
    bool begin(const Vector& b, const Vector& c, const Vector& outwards, double reach, double margin);
    // Leaves what the slab of a neighbour, at `b` from a, leaves. False if that is nothing: the bound is refuted, or a
    // touch is wrong. REQUIRES: is_known().
    bool narrow(const Vector& b, double reach, double margin);

private:
    static constexpr std::size_t kMaxExtremes = 8;

    bool cut(const Vector& u, double limit);

    Vector reference_ = Vector::Zero();  // unit, inside or near the cone
    std::array<Vector, kMaxExtremes> extremes_;
    std::uint8_t count_ = 0;
};

}  // namespace palpate
