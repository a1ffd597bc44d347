#include <cstring>

#include "tests/end_to_end/subjects.h"

namespace palpate::determinism_test {
namespace {

TEST(Determinism, SameTouchesByteForByte) {
    for (const Strategy& strategy : all_strategies()) {
        SCOPED_TRACE(strategy_name(strategy));
        const FinishedRun first(subject("torus"), 0.12, strategy);
        // Something else in between, so that memory is laid out differently.
        const auto clutter = std::make_unique<FinishedRun>(subject("genus2"), 0.2, strategy);
        const FinishedRun second(subject("torus"), 0.12, strategy);
        ASSERT_EQ(first.result().touches.size(), second.result().touches.size());
        for (std::size_t k = 0; k < first.result().touches.size(); ++k) {
            const Touch& a = first.result().touches[k];
            const Touch& b = second.result().touches[k];
            ASSERT_EQ(std::memcmp(a.position.data(), b.position.data(), sizeof(double) * 3), 0) << "touch " << k;
            ASSERT_EQ(std::memcmp(a.from.data(), b.from.data(), sizeof(double) * 3), 0) << "touch " << k;
            ASSERT_EQ(a.sample, b.sample);
        }
        EXPECT_EQ(first.result().cost.displacement(), second.result().cost.displacement());
        EXPECT_EQ(first.result().mesh.triangles, second.result().mesh.triangles);
    }
}

TEST(Determinism, WatchingChangesNothing) {
    Observer observer;
    std::size_t reports = 0;
    double last_fraction = 0;
    bool falling = false;
    observer.on_progress = [&](const Progress& p, const RunView& run) {
        ++reports;
        falling |= p.fraction_done < last_fraction || p.fraction_done > 1;
        last_fraction = p.fraction_done;
        EXPECT_EQ(run.samples.size(), p.samples);
    };
    std::size_t samples = 0;
    observer.on_sample = [&](const RunView& view) {
        ASSERT_GT(view.samples.size(), samples);
        samples = view.samples.size();
        if (samples % 64 != 0) return;
        const TriangleMesh surface = view.surface();
        ASSERT_LE(surface.points.size(), samples);
        ASSERT_FALSE(surface.triangles.empty());
        for (const Point& p : surface.points) {
            ASSERT_TRUE(std::ranges::any_of(view.touches, [&](const Touch& touch) { return touch.sample && touch.position == p; }));
        }
    };
    const FinishedRun watched(subject("torus"), 0.12, Strategy{}, observer);
    EXPECT_EQ(samples, watched.result().samples);
    const FinishedRun alone(subject("torus"), 0.12, Strategy{});
    EXPECT_FALSE(falling);
    EXPECT_GT(last_fraction, 0.5);
    EXPECT_EQ(reports + watched.result().cost.seed, watched.result().cost.probes() + 1) << "one before the first move";
    EXPECT_EQ(watched.result().cost.displacement(), alone.result().cost.displacement());
}

}  // namespace
}  // namespace palpate::determinism_test
