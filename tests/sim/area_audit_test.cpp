#include "sim/area_audit.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/random.h"

namespace palpate::area_audit_test {
namespace {

const Box kWorkspace{{-10, -10, -10}, {10, 10, 10}};
const Area kL = Prism{{{0, 0}, {8, 0}, {8, 3}, {3, 3}, {3, 8}, {0, 8}}, {0, 99}};

std::uint64_t out(const Area& area, const Segment& move) {
    AreaAudit audit(area, kWorkspace, 1e-6);
    audit.record(move);
    return audit.moves_out();
}

TEST(AreaAudit, CountsWaysThatLeaveTheArea) {
    EXPECT_EQ(out(kL, {{1, 1, 5}, {7, 2, 1}}), 0U);
    EXPECT_EQ(out(kL, {{7, 2, 5}, {2, 7, 5}}), 1U) << "over the corner that is missing";
    EXPECT_EQ(out(kL, {{7, 2, 10}, {2, 7, 10}}), 0U) << "on the workspace";
    EXPECT_EQ(out(kL, {{7, 2, 10}, {2, 7, 9.9}}), 1U);
    EXPECT_EQ(out(kL, {{1, 1, 5}, {1, 1, -0.5}}), 1U);
    EXPECT_EQ(out(kL, {{1, 1, 0}, {7, 1, 0}}), 0U) << "along the bottom";
    EXPECT_EQ(out(kL, {{40, 1, 50}, {1, 1, 10}}), 0U) << "from outside";
    EXPECT_EQ(out(kL, {{3, 8, 5}, {3, 3, 5}}), 0U) << "along a wall";
    EXPECT_EQ(out(kL, {{3 + 1e-7, 7, 5}, {1, 7, 5}}), 0U) << "within the tolerance";
    EXPECT_EQ(out(Box{{0, 0, 0}, {4, 4, 20}}, {{1, 1, 5}, {5, 1, 5}}), 1U);
}

TEST(AreaAudit, SteppingAlongAMoveSaysTheSame) {
    constexpr std::uint64_t kSeed = 20261202;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    int left = 0;
    int stayed = 0;
    int between = 0;  // out between two steps, or for hardly more than one
    for (int k = 0; k < 2000; ++k) {
        const Segment move{random.in_box({-2, -2, -2}, {10, 10, 12}), random.in_box({-2, -2, -2}, {10, 10, 12})};
        int longest = 0;  // steps in a row
        int row = 0;
        for (int step = 0; step <= 1000; ++step) {
            const Point p = move.source + step / 1000.0 * (move.target - move.source);
            row = kWorkspace.contains(p, -1e-6) && !is_inside(kL, p, -1e-6) ? row + 1 : 0;
            longest = std::max(longest, row);
        }
        const bool is_out = out(kL, move) > 0;
        if (longest > 1) {
            ASSERT_TRUE(is_out) << move.source.transpose() << " to " << move.target.transpose();
        }
        left += longest > 1 ? 1 : 0;
        stayed += longest == 0 && !is_out ? 1 : 0;
        between += longest == 0 && is_out ? 1 : 0;
    }
    EXPECT_GT(stayed, 100);
    EXPECT_LT(between, 10);
    EXPECT_GT(left, 1000);
}

}  // namespace
}  // namespace palpate::area_audit_test
