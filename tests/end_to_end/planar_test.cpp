// Planar faces: four coplanar samples have a circumcentre anywhere (planner/DESIGN.md, "Numerics").
#include <numbers>

#include "tests/end_to_end/subjects.h"

namespace palpate::planar_test {
namespace {

TEST(Planar, SharpBoxAlongTheAxes) {
    const Subject box{"sharp_box", ShapeSpec{RoundedBoxSpec{{1.6, 1.2, 0.8}, 0.0}}, Region(Ball{Point::Zero(), 1.3}), {}, {}};
    for (const Strategy& strategy : all_strategies()) {
        SCOPED_TRACE(strategy_name(strategy));
        for (const double epsilon : {0.17, 0.08}) {
            const FinishedRun run(box, epsilon, strategy);
            expect_right_result(run);
            expect_true_records(run);
        }
    }
}

TEST(Planar, SharpBoxAskewAndWithSeedsOnItsFaces) {
    ShapeSpec shape{RoundedBoxSpec{{1.6, 1.2, 0.8}, 0.0}};
    shape.rotate = Vector(10, 20, 30) * std::numbers::pi / 180;
    const Subject box{"askew",
                      shape,
                      Region(Ball{Point::Zero(), 1.3}),
                      {},
                      {{{0, 0, 1.5}, {0, 0, 0}}, {{1.5, 0, 0}, {0, 0, 0}}, {{0, -1.5, 0}, {0, 0, 0}}}};
    for (const Strategy& strategy : all_strategies()) {
        SCOPED_TRACE(strategy_name(strategy));
        expect_right_result(FinishedRun(box, 0.1, strategy));
    }
}

TEST(Planar, BunnyWhoseSamplesResolveItsTriangles) {
    const FinishedRun run(subject("bunny"), 0.118, Strategy{});
    expect_right_result(run);
    expect_true_records(run);
}

}  // namespace
}  // namespace palpate::planar_test
