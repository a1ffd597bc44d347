#include "planner/loop/audit.h"

#include <gtest/gtest.h>

#include <map>

namespace palpate::audit_test {
namespace {

std::vector<Audit::Facet> facets(std::uint32_t count) {
    std::vector<Audit::Facet> all;
    for (std::uint32_t k = 0; k < count; ++k) all.push_back({k, k + 1, k + 2});
    return all;
}

TEST(Audit, TouchesAPercentOfTheFacetsWithinItsLimits) {
    const Audit audit(0.01, 1);
    EXPECT_EQ(audit.quota(10'000, 5'000), 100U);
    EXPECT_EQ(audit.quota(10'001, 5'000), 101U) << "at least that share";
    EXPECT_EQ(audit.quota(1'000'000, 500'000), Audit::kEnough);
    EXPECT_EQ(audit.quota(4'000, 2'000), Audit::kLeast);
    EXPECT_EQ(audit.quota(800, 400), 20U) << "5 % of the samples";
    EXPECT_EQ(audit.quota(7, 4'000), 7U);
    EXPECT_EQ(Audit(1, 1).quota(200, 100), 200U) << "who asks for more than the least gets it";
    EXPECT_EQ(Audit(0, 1).quota(10'000, 5'000), 0U);
}

TEST(Audit, DrawsNoneTwiceAndEndsWhenItIsEnough) {
    Audit audit(0.01, 1);
    const std::vector<Audit::Facet> first = audit.draw(facets(8'000), 8'010);
    EXPECT_EQ(first.size(), 80U);
    // Half of them are touched; no way leads to the others.
    for (int k = 0; k < 40; ++k) audit.note(k != 7);
    EXPECT_EQ(audit.touched(), 40U);
    EXPECT_EQ(audit.wrong(), 1U);
    const std::vector<Audit::Facet> second = audit.draw(facets(7'960), 8'010);
    EXPECT_EQ(second.size(), 40U);
    for (const Audit::Facet& facet : second) EXPECT_EQ(std::ranges::count(first, facet), 0);
    for (int k = 0; k < 40; ++k) audit.note(true);
    EXPECT_TRUE(audit.draw(facets(7'920), 8'010).empty());
}

TEST(Audit, EndsWhenNoneIsLeftToDraw) {
    Audit audit(1, 1);
    EXPECT_EQ(audit.draw(facets(50), 100).size(), 50U);
    EXPECT_TRUE(audit.draw(facets(50), 100).empty()) << "though none was touched";
}

// Each of 200 facets is drawn 20,000 * 10 / 200 = 1,000 times: five standard deviations (31) either way, for 200 of them.
TEST(Audit, DrawsWithEqualChances) {
    std::map<Audit::Facet, int> times;
    for (std::uint64_t seed = 0; seed < 20'000; ++seed) {
        for (const Audit::Facet& facet : Audit(0.05, seed).draw(facets(200), 10)) ++times[facet];
    }
    ASSERT_EQ(times.size(), 200U);
    for (const auto& [facet, count] : times) EXPECT_NEAR(count, 1'000, 155) << facet[0];
}

TEST(Audit, FacetsThatItLedToAreDrawnFromAsWell) {
    Audit audit(0.01, 1);
    const auto touch = [&](const std::vector<Audit::Facet>& drawn) {
        for (std::size_t k = 0; k < drawn.size(); ++k) audit.note(true);
        return std::ranges::count_if(drawn, [](const Audit::Facet& facet) { return facet[2] >= 8'000; });
    };
    std::vector<Audit::Facet> all = facets(7'998);  // on 8,000 samples
    EXPECT_EQ(touch(audit.draw(all, 8'000)), 0);
    // Half as much again comes to light.
    all = facets(11'998);
    EXPECT_NEAR(static_cast<double>(touch(audit.draw(all, 12'000))), 40, 3) << "one in a hundred of the new";
    EXPECT_TRUE(audit.draw(all, 12'000).empty());
}

TEST(Audit, TheOrderOfFacetsChangesNothing) {
    std::vector<Audit::Facet> turned = facets(500);
    std::ranges::reverse(turned);
    EXPECT_EQ(Audit(0.1, 3).draw(facets(500), 300), Audit(0.1, 3).draw(turned, 300));
}

}  // namespace
}  // namespace palpate::audit_test
