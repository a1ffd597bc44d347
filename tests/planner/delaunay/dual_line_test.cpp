#include "planner/delaunay/dual_line.h"

#include <CGAL/Exact_rational.h>
#include <CGAL/number_utils.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/planner/support.h"

namespace palpate::dual_line_test {
namespace {

constexpr std::uint64_t kSeed = 20240612;
// Of the workspace: a tenth of the rounding that the planner allows for (planner/delaunay/validity.cc).
constexpr double kTolerance = 1e-10;

using Exact = CGAL::Exact_rational;
using Row = std::array<Exact, 3>;

Row exact(const Point& p) { return {Exact(p.x()), Exact(p.y()), Exact(p.z())}; }
Row minus(const Row& u, const Row& v) { return {u[0] - v[0], u[1] - v[1], u[2] - v[2]}; }
Exact dot(const Row& u, const Row& v) { return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]; }
Exact determinant(const Row& u, const Row& v, const Row& w) {
    return u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0]);
}
Row normal_of(const Row& a, const Row& b, const Row& c) {
    const Row u = minus(b, a);
    const Row v = minus(c, a);
    return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}

// The point x with rows[k]·x = right[k], by Cramer's rule; every circumcentre is such a point.
Row solve(const std::array<Row, 3>& rows, const Row& right) {
    const Exact divisor = determinant(rows[0], rows[1], rows[2]);
    Row x;
    for (std::size_t column = 0; column < 3; ++column) {
        std::array<Row, 3> replaced = rows;
        for (std::size_t k = 0; k < 3; ++k) replaced[k][column] = right[k];
        x[column] = determinant(replaced[0], replaced[1], replaced[2]) / divisor;
    }
    return x;
}

// As far from p as from q: 2(q - p)·x = |q|² - |p|².
Exact bisector(const Row& p, const Row& q) { return (dot(q, q) - dot(p, p)) / Exact(2); }

Row exact_circumcentre(const Row& a, const Row& b, const Row& c, const Row& d) {
    return solve({minus(b, a), minus(c, a), minus(d, a)}, {bisector(a, b), bisector(a, c), bisector(a, d)});
}
Row exact_circumcentre(const Row& a, const Row& b, const Row& c) {
    const Row n = normal_of(a, b, c);
    return solve({minus(b, a), minus(c, a), n}, {bisector(a, b), bisector(a, c), dot(n, a)});
}

// Of a rational, whatever its magnitude (a double would overflow).
double root(const Exact& squared) { return std::sqrt(CGAL::to_double(squared)); }
double distance(const Row& x, const Point& p) {
    const Row difference = minus(x, exact(p));
    return root(dot(difference, difference));
}

struct Tetrahedron {
    Point a, b, c, d;
};

// Tetrahedra whose facet is nearly collinear, or whose four points are nearly coplanar, or both, in all magnitudes.
Tetrahedron random_tetrahedron(Random& random, const Point& center, double size, int kind) {
    const auto point = [&]() -> Point { return center + Vector(size * random.in_box(Point::Constant(-1), Point::Constant(1))); };
    const auto jitter = [&] { return Vector(std::pow(10, random.uniform(-16, -3)) * size * random.direction()); };
    Tetrahedron t{point(), point(), point(), point()};
    if (kind == 1 || kind == 3) t.c = t.a + random.uniform(-0.9, 0.9) * (t.b - t.a) + jitter();
    if (kind == 2 || kind == 3) t.d = t.a + random.uniform(-1, 1) * (t.b - t.a) + random.uniform(-1, 1) * (t.c - t.a) + jitter();
    if (kind == 4) {  // a planar grid, with jitter
        const auto at = [&](double x, double y) -> Point { return center + Vector(size * Vector(x, y, 0.25)) + jitter(); };
        const double h = random.uniform(0.01, 0.5);
        t = {at(0, 0), at(h, 0), at(0, h), at(h, h)};
    }
    if (kind == 5) {  // a small tetrahedron
        const double small = std::pow(10, random.uniform(-6, 0));
        t.b = t.a + small * (t.b - t.a);
        t.c = t.a + small * (t.c - t.a);
        t.d = t.a + small * (t.d - t.a);
    }
    return t;
}
constexpr int kKinds = 6;

struct Scene {
    Point center;
    double size;  // half the side of the cube that the points are in
    // mm, of the workspace, with what its place costs in digits.
    [[nodiscard]] double scale() const { return size + 1e-3 * center.norm(); }
};
const std::vector<Scene> kScenes = {{{0, 0, 0}, 1}, {{100, -30, 55}, 40}, {{0, 0, 500}, 0.5}, {{0, 0, 0}, 1e-3}};

bool collinear(const Tetrahedron& t) {
    const Row n = normal_of(exact(t.a), exact(t.b), exact(t.c));
    return n[0] == 0 && n[1] == 0 && n[2] == 0;
}
int side_of(const Tetrahedron& t) {
    const Row a = exact(t.a);
    const Exact volume = determinant(minus(exact(t.b), a), minus(exact(t.c), a), minus(exact(t.d), a));
    return volume > 0 ? 1 : volume < 0 ? -1 : 0;
}

TEST(DualLine, OfAKnownTriangle) {
    const DualLine line = dual_line({1, 1, 5}, {3, 1, 5}, {1, 3, 5});
    EXPECT_EQ(line.origin, Point(2, 2, 5));
    EXPECT_EQ(line.direction, Vector(0, 0, 1));
    EXPECT_DOUBLE_EQ(line.circumradius, std::sqrt(2.0));
    EXPECT_EQ(line.at(-3), Point(2, 2, 2));
    // (1, 1, 6) sees the circumcentre half-way up; (1, 1, 4) half-way down.
    EXPECT_DOUBLE_EQ(circumcentre_parameter(line, {1, 1, 5}, {3, 1, 5}, {1, 3, 5}, {1, 1, 6}, 1, 100), 0.5);
    EXPECT_DOUBLE_EQ(circumcentre_parameter(line, {1, 1, 5}, {3, 1, 5}, {1, 3, 5}, {1, 1, 4}, -1, 100), -0.5);
    EXPECT_TRUE(circumcentre({1, 1, 5}, {3, 1, 5}, {1, 3, 5}, {1, 1, 6}, 100).isApprox(Point(2, 2, 5.5), 1e-15));
}

TEST(DualLine, OriginAndDirectionAgreeWithRationalArithmetic) {
    for (const Scene& scene : kScenes) {
        Random random(kSeed);
        for (int i = 0; i < 1200; ++i) {
            const Tetrahedron t = random_tetrahedron(random, scene.center, scene.size, i % kKinds);
            if (collinear(t)) continue;
            SCOPED_TRACE(seed_text(kSeed) + ", size " + std::to_string(scene.size) + ", number " + std::to_string(i));
            const Row a = exact(t.a);
            const Row m = exact_circumcentre(a, exact(t.b), exact(t.c));
            const DualLine line = dual_line(t.a, t.b, t.c);
            const double radius = distance(m, t.a);
            const double scale = scene.scale() + radius;  // a far circumcentre has that much fewer digits
            ASSERT_LE(distance(m, line.origin), kTolerance * scale);
            ASSERT_NEAR(line.circumradius, radius, kTolerance * scale);
            const Row n = normal_of(a, exact(t.b), exact(t.c));
            ASSERT_NEAR(line.direction.norm(), 1, 1e-14);
            // The sine of the angle between the two, exactly: |n × line.direction| / |n|; and the side.
            const Row direction = exact(line.direction);
            const Row sine = normal_of({0, 0, 0}, n, direction);
            ASSERT_LE(root(dot(sine, sine) / dot(n, n)), 1e-12);
            ASSERT_GT(dot(n, direction), 0);
            // Equidistant from the three points, everywhere on the part of the line in the workspace.
            if (radius > 2 * scene.size) continue;
            for (const double at : {-scene.size, 0.0, scene.size}) {
                const Point x = line.at(at);
                ASSERT_NEAR((x - t.a).norm(), (x - t.b).norm(), kTolerance * scale);
                ASSERT_NEAR((x - t.a).norm(), (x - t.c).norm(), kTolerance * scale);
            }
        }
    }
}

TEST(DualLine, SameBytesForTheSamePoints) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    for (int i = 0; i < 300; ++i) {
        const Tetrahedron t = random_tetrahedron(random, Point::Zero(), 1, i % kKinds);
        if (collinear(t)) continue;
        const DualLine first = dual_line(t.a, t.b, t.c);
        const DualLine second = dual_line(t.a, t.b, t.c);
        ASSERT_EQ(first.origin, second.origin);
        ASSERT_EQ(first.direction, second.direction);
        ASSERT_EQ(first.circumradius, second.circumradius);
    }
}

TEST(DualLine, ParameterAgreesWithRationalArithmeticAndKeepsItsSignFarOut) {
    int within = 0;
    int far_out = 0;
    for (const Scene& scene : kScenes) {
        Random random(kSeed);
        const double limit = 4 * scene.size;
        for (int i = 0; i < 1200; ++i) {
            const Tetrahedron t = random_tetrahedron(random, scene.center, scene.size, i % kKinds);
            const int side = side_of(t);
            if (side == 0) continue;
            SCOPED_TRACE(seed_text(kSeed) + ", size " + std::to_string(scene.size) + ", number " + std::to_string(i));
            const Row a = exact(t.a);
            const Row center = exact_circumcentre(a, exact(t.b), exact(t.c), exact(t.d));
            const Row m = exact_circumcentre(a, exact(t.b), exact(t.c));
            const Row n = normal_of(a, exact(t.b), exact(t.c));
            const Row from_m = minus(center, m);
            const Exact along = dot(from_m, n);
            const double truth = (along > 0 ? 1 : -1) * root(dot(from_m, from_m));
            const DualLine line = dual_line(t.a, t.b, t.c);
            const double parameter = circumcentre_parameter(line, t.a, t.b, t.c, t.d, side, limit);
            if (std::abs(truth) > 1.001 * limit) {
                ++far_out;
                ASSERT_GE(std::abs(parameter), limit);
                ASSERT_EQ(parameter > 0, truth > 0);
                continue;
            }
            const double radius = distance(m, t.a);
            if (radius > 2 * scene.size) continue;  // the line runs far from the workspace
            ++within;
            ASSERT_NEAR(parameter, truth, kTolerance * scene.scale());
            // The header's notation: x(t) is the circumcentre of the four points.
            ASSERT_LE(distance(center, line.at(parameter)), 2 * kTolerance * scene.scale());
            ASSERT_LE((circumcentre(t.a, t.b, t.c, t.d, 100 * limit) - line.at(parameter)).norm(), 2 * kTolerance * scene.scale());
        }
    }
    EXPECT_GT(within, 500);
    EXPECT_GT(far_out, 500);
}

TEST(DualLine, CircumcentreAgreesWithRationalArithmeticWithinItsLimit) {
    int within = 0;
    int far_out = 0;
    for (const Scene& scene : kScenes) {
        Random random(kSeed);
        const double limit = 4 * scene.size;
        for (int i = 0; i < 1200; ++i) {
            const Tetrahedron t = random_tetrahedron(random, scene.center, scene.size, i % kKinds);
            if (side_of(t) == 0) continue;
            SCOPED_TRACE(seed_text(kSeed) + ", size " + std::to_string(scene.size) + ", number " + std::to_string(i));
            const Row truth = exact_circumcentre(exact(t.a), exact(t.b), exact(t.c), exact(t.d));
            const Point center = circumcentre(t.a, t.b, t.c, t.d, limit);
            const double radius = distance(truth, t.a);
            if (radius > 1.001 * limit) {
                ++far_out;
                ASSERT_GE((center - t.a).norm(), limit);
                continue;
            }
            ++within;
            ASSERT_LE(distance(truth, center), kTolerance * scene.scale());
            // As much as the distances themselves tell.
            for (const Point& p : {t.b, t.c, t.d}) ASSERT_NEAR((center - p).norm(), (center - t.a).norm(), kTolerance * scene.scale());
        }
    }
    EXPECT_GT(within, 500);
    EXPECT_GT(far_out, 500);
}

}  // namespace
}  // namespace palpate::dual_line_test
