#include "planner/part/part_surface.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "planner/part/internal/bridges.h"
#include "planner/topology.h"
#include "tests/planner/part/traced_solids.h"

namespace palpate::part_surface_test {
namespace {

constexpr std::uint64_t kSeed = 7;
constexpr double kRounding = 1e-6;  // mm: points lie so near to S*

const ToolShape kFloating{2.0, {}, {}, Vector::UnitZ()};
const ToolShape kVertical{2.0, ToolShape::Shaft{1.4, 50}, {}, Vector::UnitZ()};
constexpr double kTableTop = 1.02;  // mm, grown by the ball and a clearance

using Profile = std::vector<Eigen::Vector2d>;

Box slab(double half) { return {Point(-half, -half, -3), Point(half, half, kTableTop)}; }

TracedSolid free_ball() { return {ball_distance(Point::Zero(), 10), {}, {}, {Point::Zero(), 14}}; }
TracedSolid free_torus() { return {torus_distance(Point::Zero(), 10, 4), {}, {}, {Point(10, 0, 0), 27}}; }
TracedSolid free_box() { return {box_distance({Point(-5, -4, -3), Point(5, 4, 3)}), {}, {}, {Point::Zero(), 11}}; }
// An inner edge of 90° at x = z = -1.
TracedSolid angle_bar() {
    return {prism_distance({{-5, -5}, {5, -5}, {5, -1}, {-1, -1}, {-1, 5}, {-5, 5}}, 4), {}, {}, {Point(-3, 0, -3), 17}};
}
// A groove of 60° with its bottom at x = z = 0.
TracedSolid groove() {
    const double half = 6 * std::tan(std::numbers::pi / 6);
    return {prism_distance({{-8, -3}, {8, -3}, {8, 6}, {half, 6}, {0, 0}, {-half, 6}, {-8, 6}}, 4), {}, {}, {Point(0, 0, -1.5), 17}};
}
TracedSolid ball_on_table() {
    return {ball_distance(Point(0, 0, 10), 10), capsule_distance({Point(0, 0, 10), Point(0, 0, -40)}, 10), slab(14), {Point(0, 0, 5), 40}};
}
TracedSolid box_on_table() {
    return {box_distance({Point(-5, -4, 0), Point(5, 4, 8)}),
            box_distance({Point(-5, -4, -50), Point(5, 4, 8)}),
            slab(9),
            {Point(0, 0, 1), 30}};
}
// A plate on a column.
TracedSolid overhang() {
    return {prism_distance({{-1.5, 0}, {1.5, 0}, {1.5, 6}, {5, 6}, {5, 9}, {-5, 9}, {-5, 6}, {-1.5, 6}}, 4),
            box_distance({Point(-5, -4, -44), Point(5, 4, 9)}),
            slab(9),
            {Point(0, 0, 2), 30}};
}
TracedSolid torus_on_table() {
    return {torus_distance(Point(0, 0, 4), 10, 4), swept_torus_distance(Point(0, 0, 4), 10, 4, 50), slab(18), {Point(10, 0, 1), 50}};
}

struct Figures {
    std::size_t tips = 0;
    double over = 0;                  // share of the tips that are farther off the part than stated
    double error_99 = 0;              // mm
    double error_maximum = 0;         // mm
    std::size_t shadows = 0;          // true ones
    std::size_t shadows_far_off = 0;  // called tip, and farther off the part than stated and four touch errors
    double hidden_tips = 0;           // share of the tip's true area that is not called tip, ...
    double shadowed_tips = 0;         // ... but shadow
    double facets_over = 0;           // share of measured facets whose middle is farther off than stated at their corners
};

struct Outcome {
    Trace trace;
    Compensation result;
    Figures figures;
};

double facet_area(const TriangleMesh& mesh, std::size_t f) {
    const auto& [a, b, c] = mesh.triangles[f];
    return (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]).norm() / 2;
}

Figures figures_of(const TracedSolid& solid, const Trace& trace, const Compensation& result, double noise) {
    Figures figures;
    std::vector<double> errors;
    std::size_t over = 0;
    for (std::size_t v = 0; v < result.touched.size(); ++v) {
        figures.shadows += trace.is_shadow[v];
        const TouchedPoint& touched = result.touched[v];
        if (touched.tag != PartTag::tip) continue;
        const double error = std::abs(solid.part(touched.point));
        errors.push_back(error);
        over += error > touched.uncertainty + kRounding ? 1 : 0;
        figures.shadows_far_off += trace.is_shadow[v] && error > touched.uncertainty + 4 * noise + kRounding ? 1 : 0;
    }
    std::ranges::sort(errors);
    figures.tips = errors.size();
    figures.over = static_cast<double>(over) / static_cast<double>(errors.size());
    figures.error_99 = errors[errors.size() * 99 / 100];
    figures.error_maximum = errors.back();
    double area = 0;
    double hidden = 0;
    double shadowed = 0;
    const TriangleMesh& traced = trace.surface.mesh;
    for (std::size_t f = 0; f < traced.triangles.size(); ++f) {
        const auto any = [&](auto&& is) { return std::ranges::any_of(traced.triangles[f], is); };
        if (any([&](auto v) { return trace.is_shadow[v] || trace.surface.is_fixture[v]; })) continue;
        area += facet_area(traced, f);
        if (any([&](auto v) { return result.touched[v].tag != PartTag::tip; })) hidden += facet_area(traced, f);
        if (any([&](auto v) { return result.touched[v].tag == PartTag::shadow; })) shadowed += facet_area(traced, f);
    }
    figures.hidden_tips = hidden / area;
    figures.shadowed_tips = shadowed / area;
    const PartSurface& part = result.closed;
    std::size_t measured = 0;
    std::size_t facets_over = 0;
    for (std::size_t f = 0; f < part.mesh.triangles.size(); ++f) {
        if (!is_measured(part.facet_tags[f])) continue;
        const auto& [a, b, c] = part.mesh.triangles[f];
        const double stated = std::max({part.uncertainty[a], part.uncertainty[b], part.uncertainty[c]});
        ++measured;
        facets_over +=
            std::abs(solid.part((part.mesh.points[a] + part.mesh.points[b] + part.mesh.points[c]) / 3)) > stated + kRounding ? 1 : 0;
    }
    figures.facets_over = static_cast<double>(facets_over) / static_cast<double>(measured);
    return figures;
}

Outcome run(const TracedSolid& solid, const Trace& exact, const ToolShape& tool, double noise) {
    Outcome outcome{shaken(exact, noise, kSeed), {}, {}};
    outcome.result = compensate(outcome.trace.surface, tool, {.noise = noise, .epsilon = outcome.trace.epsilon});
    outcome.figures = figures_of(solid, outcome.trace, outcome.result, noise);
    const Figures& f = outcome.figures;
    const PartReport& report = outcome.result.report;
    std::printf(
        "touch error %.3f, %zu points: tips %zu, off 99 %% %.4f, maximum %.4f, over %.2f %%, facets over %.2f %%; shadows %zu, far off "
        "%zu, "
        "tip hidden %.2f %%, called shadow %.2f %%; crossings %zu; stated median %.4f, 95 %% %.4f, maximum %.4f\n",
        noise, outcome.result.touched.size(), f.tips, f.error_99, f.error_maximum, 100 * f.over, 100 * f.facets_over, f.shadows,
        f.shadows_far_off, 100 * f.hidden_tips, 100 * f.shadowed_tips, outcome.result.closed.crossings.size(), report.uncertainty_median,
        report.uncertainty_95, report.uncertainty_maximum);
    return outcome;
}
Outcome run(const TracedSolid& solid, const ToolShape& tool, double epsilon, double noise) {
    return run(solid, trace(solid, tool, epsilon), tool, noise);
}

constexpr double kNoises[] = {0.0, 0.001, 0.01};  // mm

void expect_honest(const Figures& figures) {
    EXPECT_LE(figures.over, 0.01);
    EXPECT_LE(figures.facets_over, 0.01);
}

// Of smooth parts: within 1.5 ε²/reach and four touch errors.
void expect_smooth(const TracedSolid& solid, double epsilon, double reach) {
    const Trace exact = trace(solid, kFloating, epsilon);
    for (const double noise : kNoises) {
        SCOPED_TRACE(noise);
        const Outcome outcome = run(solid, exact, kFloating, noise);
        expect_honest(outcome.figures);
        EXPECT_EQ(outcome.figures.tips, outcome.result.touched.size());
        EXPECT_LE(outcome.figures.error_99, std::min(1.5 * epsilon * epsilon / reach, 0.001) + 4 * noise);
        EXPECT_TRUE(analyse_topology(outcome.result.closed.mesh).is_closed_oriented_manifold());
        EXPECT_TRUE(outcome.result.closed.crossings.empty());
    }
}

TEST(PartSurface, ABallComesBack) { expect_smooth(free_ball(), 0.9, 10); }
TEST(PartSurface, ATorusComesBack) { expect_smooth(free_torus(), 0.64, 4); }

TEST(PartSurface, SharpEdgesComeBack) {
    const Trace exact = trace(free_box(), kFloating, 0.45);
    for (const double noise : kNoises) {
        SCOPED_TRACE(noise);
        const Outcome outcome = run(free_box(), exact, kFloating, noise);
        expect_honest(outcome.figures);
        EXPECT_EQ(outcome.figures.tips, outcome.result.touched.size());
        EXPECT_LE(outcome.figures.error_99, 0.015 + 4 * noise);
        EXPECT_TRUE(analyse_topology(outcome.result.closed.mesh).is_closed_oriented_manifold());
    }
}

// Medians of what is stated of points on an inner edge along y, away from its ends, and of their distance from it.
std::pair<double, double> at_inner_edge(const PartSurface& part, const Point& edge) {
    std::vector<double> stated;
    std::vector<double> distances;
    for (std::size_t v = 0; v < part.mesh.points.size(); ++v) {
        const Vector to = part.mesh.points[v] - edge;
        if (part.tags[v] != PartTag::bridged || std::abs(to.y()) > 2.5) continue;
        stated.push_back(part.uncertainty[v]);
        distances.push_back(std::hypot(to.x(), to.z()));
    }
    EXPECT_GT(stated.size(), 10U);
    const auto median = [](std::vector<double>& values) {
        std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
        return values[values.size() / 2];
    };
    return {median(stated), median(distances)};
}

TEST(PartSurface, InnerEdgesAreBridgedWithTheGapAsUncertainty) {
    const auto expect_gap = [](const TracedSolid& solid, const Point& edge, double gap) {
        const Trace exact = trace(solid, kFloating, 0.5);
        for (const double noise : kNoises) {
            SCOPED_TRACE(noise);
            const Outcome outcome = run(solid, exact, kFloating, noise);
            expect_honest(outcome.figures);
            const auto [stated, distance] = at_inner_edge(outcome.result.closed, edge);
            EXPECT_GE(stated, gap);
            EXPECT_LE(stated, 1.3 * gap + 4 * noise);
            EXPECT_NEAR(distance, gap, 0.05 * gap + 4 * noise);
        }
    };
    expect_gap(angle_bar(), {-1, 0, -1}, std::numbers::sqrt2 - 1);
    expect_gap(groove(), {0, 0, 0}, 1);
    EXPECT_NEAR(bridge_gap(1, std::numbers::pi / 2), std::numbers::sqrt2 - 1, 1e-12);
    EXPECT_NEAR(bridge_gap(2, std::numbers::pi * 2 / 3), 2, 1e-12);
}

void expect_shadows(const TracedSolid& solid, double epsilon, double most_hidden) {
    const Trace exact = trace(solid, kVertical, epsilon);
    for (const double noise : kNoises) {
        SCOPED_TRACE(noise);
        const Outcome outcome = run(solid, exact, kVertical, noise);
        expect_honest(outcome.figures);
        EXPECT_GT(outcome.figures.shadows, 100U);
        EXPECT_EQ(outcome.figures.shadows_far_off, 0U);
        // Beside a shadow the shank is as near to the part as touches tell, over a band as wide as they are off: facets count as a whole.
        EXPECT_LE(outcome.figures.shadowed_tips, 0.01);
        EXPECT_LE(outcome.figures.hidden_tips, most_hidden);
    }
}

TEST(PartSurface, ShadowsOfABallAreNotMeasured) { expect_shadows(ball_on_table(), 0.6, 0.02); }
TEST(PartSurface, ShadowsOfATorusAreNotMeasured) { expect_shadows(torus_on_table(), 0.6, 0.02); }
TEST(PartSurface, ShadowsOfAnOverhangAreNotMeasured) { expect_shadows(overhang(), 0.35, 0.025); }

TEST(PartSurface, ATrueWallIsNoShadow) {
    const Trace exact = trace(box_on_table(), kVertical, 0.5);
    for (const double noise : kNoises) {
        SCOPED_TRACE(noise);
        const Outcome outcome = run(box_on_table(), exact, kVertical, noise);
        expect_honest(outcome.figures);
        EXPECT_LE(outcome.figures.hidden_tips, 0.001);
        EXPECT_EQ(outcome.result.report.area[static_cast<std::size_t>(PartTag::shadow)], 0);
    }
}

// Radii that differ by five touch errors are told apart: walls may be ambiguous then, and are no shadows.
TEST(PartSurface, ATrueWallIsNoShadowOfAShankThatIsHardlyThinner) {
    const ToolShape tool{2.0, ToolShape::Shaft{1.9, 50}, {}, Vector::UnitZ()};
    const Outcome outcome = run(box_on_table(), tool, 0.5, 0.01);
    constexpr double kWalls = 2 * (10 + 8) * 7;  // mm²
    EXPECT_LE(outcome.result.report.area[static_cast<std::size_t>(PartTag::shadow)], 0.01 * kWalls);
}

TEST(PartSurface, AShankAsWideAsTheBallLeavesWallsAmbiguous) {
    const ToolShape cylinder{2.0, ToolShape::Shaft{2.0, 50}, {}, Vector::UnitZ()};
    const Outcome outcome = run(box_on_table(), cylinder, 0.5, 0.001);
    for (std::size_t v = 0; v < outcome.result.touched.size(); ++v) {
        const TouchedPoint& touched = outcome.result.touched[v];
        EXPECT_NE(touched.tag, PartTag::shadow);
        const Point& p = touched.point;
        const bool is_on_wall = p.z() > 1 && p.z() < 6.5 && std::abs(p.y()) < 3.5 && std::abs(p.x()) > 4.9;
        if (is_on_wall && touched.tag != PartTag::fixture) {
            EXPECT_EQ(touched.tag, PartTag::ambiguous) << p.transpose();
            EXPECT_TRUE(std::isinf(touched.uncertainty));
        }
    }
}

TEST(PartSurface, AShadowIsKeptBelowWhatCastsItAndCutOffWhenAsked) {
    const Outcome outcome = run(ball_on_table(), kVertical, 0.6, 0.001);
    for (const TouchedPoint& touched : outcome.result.touched) {
        if (touched.tag != PartTag::shadow || touched.point.z() > 5.5) continue;
        EXPECT_NEAR(touched.point.head<2>().norm(), 10, 0.02);
        EXPECT_TRUE(std::isinf(touched.uncertainty));
    }
    const PartSurface& closed = outcome.result.closed;
    EXPECT_EQ(analyse_topology(closed.mesh).boundary_edges, 0U);
    const PartSurface open = without_unmeasured(closed);
    EXPECT_GT(analyse_topology(open.mesh).boundary_edges, 0U);
    EXPECT_EQ(open.normals.size(), open.mesh.points.size());
    EXPECT_EQ(open.uncertainty.size(), open.mesh.points.size());
    EXPECT_EQ(open.tags.size(), open.mesh.points.size());
    EXPECT_EQ(open.facet_tags.size(), open.mesh.triangles.size());
    for (const PartTag tag : open.facet_tags) EXPECT_TRUE(is_measured(tag));
    for (const double stated : open.uncertainty) EXPECT_TRUE(std::isfinite(stated));
    const PartReport report = report_on(open);
    for (const PartTag tag : {PartTag::tip, PartTag::bridged}) {
        const auto k = static_cast<std::size_t>(tag);
        EXPECT_NEAR(report.area[k], outcome.result.report.area[k], 1e-9);
    }
    EXPECT_EQ(report.uncertainty_maximum, outcome.result.report.uncertainty_maximum);
}

// A tool that lies on its side sees the same as one that stands, turned.
TEST(PartSurface, TheAxisMayPointAnywhere) {
    Outcome outcome = run(ball_on_table(), kVertical, 0.8, 0.001);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(1.1, Vector(1, 2, -0.5).normalized()));
    TracedSurface turned = outcome.trace.surface;
    for (Point& p : turned.mesh.points) p = turn * p;
    ToolShape tool = kVertical;
    tool.axis = turn * tool.axis;
    const Compensation result = compensate(turned, tool, {.noise = 0.001, .epsilon = outcome.trace.epsilon * 1.001});
    // Ties beside creases are decided by rounding.
    std::size_t other = 0;
    for (std::size_t v = 0; v < result.touched.size(); ++v) {
        const TouchedPoint& standing = outcome.result.touched[v];
        const bool is_same = result.touched[v].tag == standing.tag && (turn * standing.point - result.touched[v].point).norm() < 0.01;
        other += is_same ? 0 : 1;
    }
    EXPECT_LE(other, result.touched.size() / 200);
}

TEST(PartSurface, ATouchOfTheHolderIsAShadow) {
    // A wide holder shortly above the ball meets the ball of the part before the shank does.
    const ToolShape tool{2.0, ToolShape::Shaft{1.4, 8}, ToolShape::Shaft{6.0, 40}, Vector::UnitZ()};
    const Distance part = ball_distance(Point(0, 0, 10), 10);
    const double holder = 3;
    TracedSolid solid = ball_on_table();
    // As the shank's surface is 0.7 off, that of the holder is 0.7 − 3 deeper.
    const Distance by_shank = solid.swept;
    const Distance by_holder = capsule_distance({Point(0, 0, 2), Point(0, 0, -38)}, 10 + holder - 0.7);
    solid.swept = [=](const Point& p) { return std::min(by_shank(p), by_holder(p)); };
    solid.fixture = slab(17);
    const Outcome outcome = run(solid, tool, 0.8, 0.001);
    EXPECT_EQ(outcome.figures.shadows_far_off, 0U);
    std::size_t below = 0;
    for (std::size_t v = 0; v < outcome.result.touched.size(); ++v) {
        const Point& c = outcome.trace.surface.mesh.points[v];
        if (!outcome.trace.is_shadow[v] || std::abs(c.head<2>().norm() - 13) > 0.01 || c.z() > 1.9) continue;
        ++below;
        EXPECT_EQ(outcome.result.touched[v].tag, PartTag::shadow);
        EXPECT_NEAR(outcome.result.touched[v].point.head<2>().norm(), 10, 0.05);
    }
    EXPECT_GT(below, 20U);
}

TEST(PartSurface, WideFacetsAreUntouched) {
    const Outcome outcome = run(free_ball(), kFloating, 2.0, 0);
    const Compensation result = compensate(outcome.trace.surface, kFloating, {.noise = 0, .epsilon = 0.8 * outcome.trace.epsilon});
    std::size_t untouched = 0;
    for (const PartTag tag : result.closed.facet_tags) untouched += tag == PartTag::untouched ? 1 : 0;
    EXPECT_GT(untouched, 0U);
    EXPECT_LT(untouched, result.closed.facet_tags.size());
}

TEST(PartSurface, WhereTheToolCameFromTurnsNormals) {
    Outcome outcome = run(free_ball(), kFloating, 2.0, 0);
    TracedSurface traced = outcome.trace.surface;
    traced.to_tool.assign(traced.mesh.points.size(), Vector::Zero());
    traced.to_tool[5] = -traced.mesh.points[5].normalized();  // from inside, which contradicts the mesh
    const Compensation result = compensate(traced, kFloating, {.noise = 0, .epsilon = outcome.trace.epsilon});
    EXPECT_GT(result.touched[5].uncertainty, 0.5);
    EXPECT_LT(result.touched[6].uncertainty, 0.1);
}

TEST(PartSurface, WhatIsNoSurfaceIsRefused) {
    const TracedSurface good{
        {{Point(0, 0, 0), Point(1, 0, 0), Point(0, 1, 0), Point(0, 0, 1)}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}}, {}, {}};
    const CompensationOptions options{.noise = 0, .epsilon = 1};
    EXPECT_NO_THROW((void)compensate(good, kFloating, options));
    TracedSurface bad = good;
    bad.mesh.triangles.clear();
    EXPECT_THROW((void)compensate(bad, kFloating, options), std::invalid_argument);
    bad = good;
    bad.mesh.triangles[0][0] = 4;
    EXPECT_THROW((void)compensate(bad, kFloating, options), std::invalid_argument);
    bad = good;
    bad.mesh.points[0].x() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)compensate(bad, kFloating, options), std::invalid_argument);
    bad = good;
    bad.is_fixture = {1};
    EXPECT_THROW((void)compensate(bad, kFloating, options), std::invalid_argument);
    EXPECT_THROW((void)compensate(good, {0, {}, {}, Vector::UnitZ()}, options), std::invalid_argument);
    EXPECT_THROW((void)compensate(good, kFloating, {.noise = -1, .epsilon = 1}), std::invalid_argument);
    EXPECT_THROW((void)compensate(good, kFloating, {.noise = 0, .epsilon = 0}), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::part_surface_test
