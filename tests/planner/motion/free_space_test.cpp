#include "planner/motion/free_space.h"

#include <gtest/gtest.h>

#include "planner/inference/inference.h"
#include "tests/planner/torus.h"

namespace palpate::free_space_test {
namespace {

// Samples all over a torus, with their lenses.
class FreeSpaceOnTorus : public ::testing::Test {
protected:
    FreeSpaceOnTorus() {
        Random random(7);
        std::vector<Point> samples;
        while (samples.size() < 1500) {
            const Point p = torus_.random_place(random).point;
            const bool spaced = std::all_of(samples.begin(), samples.end(), [&](const Point& q) { return (p - q).norm() > kSpacing; });
            if (spaced || random.chance(0.001)) samples.push_back(p);
            if (++tries_ > 200'000) break;
        }
        state_.initialise(samples);
        for (std::uint32_t k = 0; k < samples.size(); ++k) inference_.note_sample(k, torus_.nearest(samples[k]).normal);
    }

    // Nothing of the way comes into the torus.
    void expect_free(const Point& from, const std::vector<Point>& points) {
        Point before = from;
        for (const Point& p : points) {
            for (int k = 0; k <= 50; ++k) ASSERT_GT(torus_.distance(before + k / 50.0 * (p - before)), 0);
            before = p;
        }
    }

    static constexpr double kSpacing = 0.07;
    const Torus torus_;
    int tries_ = 0;
    const Region workspace_{Ball{Point::Zero(), 2}};
    MaintainedDelaunay state_{workspace_};
    Inference inference_{state_, torus_.minor, 0.3, 1e-12};
    FreeSpace free_space_{state_, inference_, 0.05};
};

TEST_F(FreeSpaceOnTorus, ASegmentThatLensesCoverIsFree) {
    Random random(8);
    std::vector<std::uint32_t> all(state_.sample_count());
    for (std::uint32_t k = 0; k < all.size(); ++k) all[k] = k;
    int free = 0;
    int blocked = 0;
    for (int k = 0; k < 3000; ++k) {
        const auto place = torus_.random_place(random);
        const Point from = place.point + random.uniform(-0.02, 0.2) * place.normal;
        const Point to = from + random.uniform(0, 0.5) * random.direction();
        if (free_space_.is_free(from, to, all)) {
            ++free;
            expect_free(from, {to});
        } else {
            ++blocked;
        }
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(free, 300);
    EXPECT_GT(blocked, 300);
}

TEST_F(FreeSpaceOnTorus, WaysLeadAroundAndAreNotMuchLongerThanTheSurfaceIsWide) {
    Random random(9);
    int ways = 0;
    for (int k = 0; k < 200; ++k) {
        const auto from = static_cast<std::uint32_t>(random.below(state_.sample_count()));
        const auto to = static_cast<std::uint32_t>(random.below(state_.sample_count()));
        if (!inference_.knows(from) || !inference_.knows(to)) continue;
        const HoverPlace start{state_.sample(from) + 0.05 * inference_.normal(from), from};
        const HoverPlace goal{state_.sample(to) + 0.05 * inference_.normal(to), to};
        const auto way = free_space_.way(start, goal);
        ASSERT_TRUE(way);
        ++ways;
        EXPECT_EQ(way->stops.back().point, goal.point);
        std::vector<Point> points;
        for (const HoverPlace& stop : way->stops) points.push_back(stop.point);
        expect_free(start.point, points);
        EXPECT_DOUBLE_EQ(way->length, path_length(start.point, points));
        if (HasFatalFailure()) return;
        // Halfway around the axis on the outside, and halfway around the tube.
        EXPECT_LE(way->length, 1.3 * std::numbers::pi * (torus_.major + 2 * torus_.minor));
    }
    EXPECT_GT(ways, 150);
}

}  // namespace
}  // namespace palpate::free_space_test
