#include "sim/facet_truth.h"

#include <gtest/gtest.h>

namespace palpate::facet_truth_test {
namespace {

// A corner on the unit sphere's top, and a dual edge that begins above it and ends at that height. The ball's centre is the top itself, or
// as far away as the edge is beside it.
FacetVerdict judge(double end_height, double beside, double epsilon) {
    const HiddenObject sphere(ShapeSpec{SphereSpec{1}});
    const TriangleMesh mesh{{{0, 0, 1}, {0.1, 0, 0.995}, {0, 0.1, 0.995}}, {{0, 1, 2}}};
    const std::vector<Segment> dual{{{beside, 0, 1.5}, {beside, 0, end_height}}};
    return judge_facets(sphere, mesh, dual, epsilon).front();
}

TEST(FacetTruth, AFacetIsRightIfItsDualEdgeMeetsTheSurfaceWithinTheBall) {
    EXPECT_EQ(judge(0.5, 0, 0.1), FacetVerdict::right);
    EXPECT_EQ(judge(0.5, 0.09, 0.1), FacetVerdict::right);
    EXPECT_EQ(judge(0.5, 0.11, 0.1), FacetVerdict::wrong) << "too large a ball";
}

TEST(FacetTruth, PassingByLittleIsAFlip) {
    EXPECT_EQ(judge(1.004, 0, 0.1), FacetVerdict::flip);
    EXPECT_EQ(judge(1.006, 0, 0.1), FacetVerdict::wrong);
}

TEST(FacetTruth, AnEdgeThatLeavesTheObjectAgainIsJudgedByItsBall) {
    // It meets the far side, too.
    EXPECT_EQ(judge(-1.5, 0, 0.1), FacetVerdict::right);
}

}  // namespace
}  // namespace palpate::facet_truth_test
