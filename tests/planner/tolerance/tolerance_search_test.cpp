// Where touches are asked for, against a surface that is known.
#include "planner/tolerance/tolerance_search.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numeric>

namespace palpate::tolerance_search_test {
namespace {

// A grid on the torus around z; the ball of a facet is not far from its middle.
SampledSurface sampled_torus(int around, int across) {
    constexpr double kMajor = 1.0;
    constexpr double kMinor = 0.4;
    SampledSurface surface;
    for (int i = 0; i < around; ++i) {
        for (int j = 0; j < across; ++j) {
            const double u = 2 * M_PI * (i + 0.5 * (j % 2)) / around;
            const double v = 2 * M_PI * j / across;
            const double r = kMajor + kMinor * std::cos(v);
            surface.mesh.points.emplace_back(r * std::cos(u), r * std::sin(u), kMinor * std::sin(v));
        }
    }
    const auto at = [&](int i, int j) {
        return static_cast<std::uint32_t>(((i % around) + around) % around * across + ((j % across) + across) % across);
    };
    for (int i = 0; i < around; ++i) {
        for (int j = 0; j < across; ++j) {
            const int shift = j % 2;
            surface.mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + shift, j + 1)});
            surface.mesh.triangles.push_back({at(i + 1, j), at(i + shift + 1, j + 1), at(i + shift, j + 1)});
        }
    }
    for (const auto& [a, b, c] : surface.mesh.triangles) {
        surface.ball_centres.emplace_back((surface.mesh.points[a] + surface.mesh.points[b] + surface.mesh.points[c]) / 3);
        surface.ball_radii.push_back((surface.ball_centres.back() - surface.mesh.points[a]).norm());
    }
    surface.sample_of.resize(surface.mesh.points.size());
    std::iota(surface.sample_of.begin(), surface.sample_of.end(), 0U);
    surface.is_known.assign(surface.mesh.triangles.size(), 0);
    return surface;
}

double off_torus(const Point& p) { return std::hypot(std::hypot(p.x(), p.y()) - 1, p.z()) - 0.4; }

// Along the place's normal to the torus.
Point touched(const ToleranceSearch::Place& place) {
    Point p = place.at;
    for (int k = 0; k < 50; ++k) p -= off_torus(p) * place.normal;
    return p;
}

ToleranceSearch::Options options(double tolerance) { return {tolerance, 0.5, tolerance, 0.0, 1}; }

// Surprises that are just what is stated.
void calibrate(ToleranceSearch& search, const SampledSurface& surface) {
    for (const auto& place : search.places(surface)) search.note(place, place.at + place.stated * place.normal, true);
}

TEST(ToleranceSearch, AsksForNothingWhereItIsMetAndForAllWhereItIsNot) {
    const SampledSurface surface = sampled_torus(24, 12);
    EXPECT_TRUE(ToleranceSearch(options(0.2)).places(surface).empty());
    ToleranceSearch strict(options(1e-6));
    EXPECT_EQ(strict.places(surface).size(), 20U) << "nothing is known yet of how good that is";
    calibrate(strict, surface);
    EXPECT_EQ(strict.places(surface).size(), surface.mesh.triangles.size());
    EXPECT_GT(strict.evidence().foretold, 1e-6);
    EXPECT_EQ(strict.evidence().unmet_facets, 0U);
}

TEST(ToleranceSearch, PlacesLieWhereTheSurfaceIsForetold) {
    ToleranceSearch search(options(1e-5));
    calibrate(search, sampled_torus(24, 12));
    for (const ToleranceSearch::Place& place : search.places(sampled_torus(24, 12))) {
        EXPECT_LT(std::abs(off_torus(place.at)), 0.01);
        EXPECT_NEAR(place.normal.norm(), 1, 1e-9);
        EXPECT_GT(place.stated, 0);
        EXPECT_GT(place.spacing, 0.05);
    }
}

TEST(ToleranceSearch, KnownFacetsAreNeitherTouchedNorDrawn) {
    SampledSurface surface = sampled_torus(24, 12);
    for (std::size_t f = 0; f < surface.mesh.triangles.size(); ++f) surface.is_known[f] = surface.ball_centres[f].x() > 0 ? 1 : 0;
    ToleranceSearch search(options(1e-6));
    for (const auto& place : search.places(surface)) EXPECT_LT(place.at.x(), 0.2);
    for (const auto& place : search.draw(surface, 200)) EXPECT_LT(place.at.x(), 0.3);
}

TEST(ToleranceSearch, WhereATouchWasInVainTheCentreOfTheBallIsTouchedOnce) {
    const SampledSurface surface = sampled_torus(24, 12);
    ToleranceSearch search(options(1e-6));
    calibrate(search, surface);
    const std::size_t facets = surface.mesh.triangles.size();
    const auto places = search.places(surface);
    for (const auto& place : places) search.note(place, place.at + place.stated * place.normal, false);
    const auto centres = search.places(surface);
    ASSERT_EQ(centres.size(), facets);
    for (std::size_t f = 0; f < facets; ++f) {
        EXPECT_EQ(centres[f].at, surface.ball_centres[f]);
        EXPECT_EQ(centres[f].stated, 0) << "the curved surface does not foretell that";
        const auto& [a, b, c] = surface.mesh.triangles[f];
        const Point& p = surface.mesh.points[a];
        EXPECT_NEAR(centres[f].normal.dot(surface.mesh.points[b] - p), 0, 1e-12);
        EXPECT_NEAR(centres[f].normal.dot(surface.mesh.points[c] - p), 0, 1e-12);
        // Of the facet's circle, by Heron's formula.
        const double u = (surface.mesh.points[b] - p).norm();
        const double v = (surface.mesh.points[c] - p).norm();
        const double w = (surface.mesh.points[b] - surface.mesh.points[c]).norm();
        const double half = (u + v + w) / 2;
        EXPECT_NEAR(centres[f].spacing, 0.9 * u * v * w / (4 * std::sqrt(half * (half - u) * (half - v) * (half - w))), 1e-9);
        search.note(centres[f], centres[f].at, false);
    }
    EXPECT_TRUE(search.places(surface).empty());
    EXPECT_EQ(search.evidence().unmet_facets, facets);
    EXPECT_EQ(search.evidence().touched, 20 + 2 * facets);
}

TEST(ToleranceSearch, WithinABoxAlone) {
    const SampledSurface surface = sampled_torus(24, 12);
    ToleranceSearch::Options within = options(1e-6);
    within.box = Box{{0.5, -2, -2}, {2, 2, 2}};
    ToleranceSearch search(within);
    calibrate(search, surface);
    const auto places = search.places(surface);
    EXPECT_GT(places.size(), 40U);
    for (const auto& place : places) EXPECT_TRUE(within.box->contains(place.at));
    for (const auto& place : search.draw(surface, 200)) EXPECT_TRUE(within.box->contains(place.at, 0.3));
}

TEST(ToleranceSearch, APlaceThatWasBarredIsTriedOnceMore) {
    const SampledSurface surface = sampled_torus(24, 12);
    ToleranceSearch search(options(1e-6));
    calibrate(search, surface);
    const ToleranceSearch::Place place = search.places(surface).front();
    const std::size_t all = search.places(surface).size();
    search.note(place, std::nullopt, false);
    EXPECT_EQ(search.places(surface).size(), all);
    EXPECT_GT(search.places(surface).front().stated, 0);
    search.note(place, std::nullopt, false);
    EXPECT_EQ(search.places(surface).front().stated, 0) << "the centre of its ball, now";
}

TEST(ToleranceSearch, NearerThanTheLeastSpacingNothingIsAskedFor) {
    ToleranceSearch::Options coarse = options(1e-6);
    coarse.spacing_min = 1;
    const SampledSurface surface = sampled_torus(24, 12);
    ToleranceSearch search(coarse);
    EXPECT_TRUE(search.places(surface).empty());
    EXPECT_EQ(search.evidence().unmet_facets, surface.mesh.triangles.size());
}

TEST(ToleranceSearch, SurprisesScaleWhatIsForetold) {
    const SampledSurface surface = sampled_torus(24, 12);
    ToleranceSearch good(options(1e-6));
    ToleranceSearch bad(options(1e-6));
    const auto places = good.places(surface);
    (void)bad.places(surface);
    const double before = good.evidence().foretold;
    for (const auto& place : places) {
        good.note(place, place.at + place.stated / 2 * place.normal, true);
        bad.note(place, place.at - place.stated * 3 * place.normal, true);
    }
    (void)good.places(surface);
    (void)bad.places(surface);
    EXPECT_NEAR(good.evidence().foretold, before / 2, 1e-9);
    EXPECT_NEAR(bad.evidence().foretold, before * 3, 1e-9);
}

TEST(ToleranceSearch, WhatIsForetoldHoldsOnATorus) {
    const SampledSurface surface = sampled_torus(24, 12);
    ToleranceSearch search(options(1e-6));
    calibrate(search, surface);
    const auto places = search.places(surface);
    std::size_t within = 0;
    for (const auto& place : places) within += (touched(place) - place.at).norm() <= place.stated ? 1 : 0;
    EXPECT_GE(within, places.size() * 93 / 100);
}

TEST(ToleranceSearch, PlacesAreDrawnByArea) {
    // Outer and inner half of a torus: (1 ± 2 r/π R) / 2 of the area each.
    ToleranceSearch search(options(1e-3));
    const auto drawn = search.draw(sampled_torus(48, 24), 4000);
    ASSERT_EQ(drawn.size(), 4000U);
    std::size_t outer = 0;
    for (const auto& place : drawn) outer += std::hypot(place.at.x(), place.at.y()) > 1 ? 1 : 0;
    EXPECT_NEAR(static_cast<double>(outer) / 4000, (1 + 0.8 / M_PI) / 2, 0.03);
}

TEST(ToleranceSearch, AnAuditCountsWhatIsBeyond) {
    const SampledSurface surface = sampled_torus(24, 12);
    ToleranceSearch search(options(0.01));
    const auto drawn = search.draw(surface, 3);
    ASSERT_EQ(drawn.size(), 3U);
    search.note_audit(drawn[0], drawn[0].at + 0.005 * drawn[0].normal);
    search.note_audit(drawn[1], drawn[1].at - 0.03 * drawn[1].normal);
    search.note_audit(drawn[2], std::nullopt);
    EXPECT_EQ(search.evidence().audited, 2U);
    EXPECT_EQ(search.evidence().beyond, 1U);
    EXPECT_EQ(search.evidence().barred, 1U);
    EXPECT_NEAR(search.evidence().worst, 0.03, 1e-12);
}

TEST(ToleranceSearch, WhatWasStatedIsComparedWithWhatWasMet) {
    const SampledSurface surface = sampled_torus(24, 12);
    ToleranceSearch search(options(0.01));
    ToleranceSearch::Place place = search.draw(surface, 1).front();
    const auto meet = [&](double stated, double off) {
        place.stated = stated;
        search.note_audit(place, place.at + off * place.normal);
    };
    meet(0.001, 0.0005);
    meet(0.0025, 0.0026);
    meet(0.0025, 0.0024);
    meet(0.01, 0.02);
    meet(0.5, 0.4);
    meet(0, 0.4);  // nothing was stated
    const auto& stated = search.evidence().stated;
    const std::array<std::array<double, 5>, 5> expected = {{{0, 0.0025, 3, 2, 0.0026},
                                                            {0.0025, 0.005, 0, 0, 0},
                                                            {0.005, 0.01, 1, 0, 0.02},
                                                            {0.01, 0.02, 0, 0, 0},
                                                            {0.02, INFINITY, 1, 1, 0.4}}};
    for (std::size_t k = 0; k < 5; ++k) {
        EXPECT_DOUBLE_EQ(stated[k].least, expected[k][0]);
        EXPECT_DOUBLE_EQ(stated[k].most, expected[k][1]);
        EXPECT_EQ(static_cast<double>(stated[k].touched), expected[k][2]);
        EXPECT_EQ(static_cast<double>(stated[k].within), expected[k][3]);
        EXPECT_NEAR(stated[k].worst, expected[k][4], 1e-12);
    }
}

TEST(ToleranceSearch, TheSameSeedDrawsTheSamePlaces) {
    const SampledSurface surface = sampled_torus(24, 12);
    ToleranceSearch::Options other = options(0.01);
    other.random_seed = 2;
    const auto one = ToleranceSearch(options(0.01)).draw(surface, 20);
    const auto same = ToleranceSearch(options(0.01)).draw(surface, 20);
    const auto different = ToleranceSearch(other).draw(surface, 20);
    bool all_same = true;
    for (std::size_t k = 0; k < 20; ++k) {
        EXPECT_EQ(one[k].at, same[k].at);
        all_same = all_same && one[k].at == different[k].at;
    }
    EXPECT_FALSE(all_same);
}

}  // namespace
}  // namespace palpate::tolerance_search_test
