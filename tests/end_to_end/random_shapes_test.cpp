// Random shapes, placements, workspaces, seeds and strategies.
#include <numbers>
#include <random>

#include "tests/end_to_end/subjects.h"

namespace palpate::random_shapes_test {
namespace {

class RandomShapes : public ::testing::TestWithParam<std::uint64_t> {
protected:
    double uniform(double low, double high) { return low + (high - low) * static_cast<double>(random_() >> 11U) * 0x1p-53; }
    std::mt19937_64 random_{GetParam()};
};

TEST_P(RandomShapes, EndWithTheTruth) {
    RecordProperty("seed", std::to_string(GetParam()));
    SCOPED_TRACE("seed " + std::to_string(GetParam()));
    ShapeSpec shape;
    switch (random_() % 5) {
        case 0:
            shape.kind = EllipsoidSpec{{uniform(0.7, 1.2), uniform(0.7, 1.2), uniform(0.7, 1.2)}};
            break;
        case 1:
            shape.kind = TorusSpec{uniform(0.8, 1.2), uniform(0.25, 0.5)};
            break;
        case 2:
            shape.kind = CapsuleSpec{uniform(0.3, 0.6), uniform(0.3, 1.2)};
            break;
        case 3:
            shape.kind = RoundedBoxSpec{{uniform(0.8, 1.5), uniform(0.8, 1.5), uniform(0.8, 1.5)}, uniform(0.2, 0.4)};
            break;
        default:
            shape.kind = Genus2Spec{uniform(0.8, 1.2)};
            break;
    }
    shape.at = {uniform(-5, 5), uniform(-5, 5), uniform(-5, 5)};
    shape.rotate = {uniform(0, 6), uniform(0, 6), uniform(0, 6)};
    const HiddenObject object{ObjectSpec(shape)};
    const Box& bounds = object.bounds();
    const Vector spare(uniform(0.05, 0.3), uniform(0.05, 0.3), uniform(0.05, 0.3));
    const Region workspace = random_() % 2 == 0 ? Region(Ball{bounds.center() + spare, bounds.diagonal() / 2 + 0.6})
                                                : Region(Box{bounds.min - spare, bounds.max + 2 * spare});
    const Subject random_subject{"random", shape, workspace, {}, {}};
    const Strategy strategy = all_strategies()[random_() % 5];
    const double epsilon = uniform(0.15, 0.4) * *object.reach();
    SCOPED_TRACE("epsilon " + std::to_string(epsilon) + " " + strategy_name(strategy));
    const FinishedRun run(random_subject, epsilon, strategy);
    expect_right_result(run);
    expect_sparse(run);
    expect_true_records(run);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomShapes, ::testing::Range<std::uint64_t>(1, 21));

}  // namespace
}  // namespace palpate::random_shapes_test
