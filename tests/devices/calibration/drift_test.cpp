#include "devices/calibration/drift.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/devices/message_of.h"
#include "tests/random.h"

namespace palpate::drift_test {
namespace {

TEST(Drift, IsLinearBetweenReadingsAndConstantBeyond) {
    const std::vector<DriftReading> readings{{0, Vector::Zero()}, {100, Vector(0.01, 0, -0.02)}, {300, Vector(0.03, 0, 0)}};
    require_steady(readings, 0.05);
    EXPECT_EQ(drift_at({}, 5), Vector::Zero());
    EXPECT_EQ(drift_at(readings, -5), Vector::Zero());
    EXPECT_NEAR((drift_at(readings, 50) - Vector(0.005, 0, -0.01)).norm(), 0, 1e-12);
    EXPECT_NEAR((drift_at(readings, 100) - Vector(0.01, 0, -0.02)).norm(), 0, 1e-12);
    EXPECT_NEAR((drift_at(readings, 200) - Vector(0.02, 0, -0.01)).norm(), 0, 1e-12);
    EXPECT_EQ(drift_at(readings, 300), Vector(0.03, 0, 0));
    EXPECT_EQ(drift_at(readings, 1e9), Vector(0.03, 0, 0));
    EXPECT_NEAR((without_drift(Point(1, 1, 1), readings, 200) - Point(0.98, 1, 1.01)).norm(), 0, 1e-12);
}

TEST(Drift, AJumpIsRefused) {
    const auto message = [](const std::vector<DriftReading>& readings, double limit) {
        return message_of<DriftError>([&] { require_steady(readings, limit); });
    };
    expect_says(message({{0, Vector::Zero()}, {40, Vector(0, 0, 0.01)}, {80, Vector(0, 0, 0.06)}}, 0.02),
                "the datum jumped by 0.0500 mm between 40 and 80, more than 0.0200 mm");
    expect_says(message({{0, Vector::Zero()}, {0, Vector::Zero()}}, 0.02), "readings 1 and 2 of the drift are not in order");
    expect_says(message({{std::numeric_limits<double>::quiet_NaN(), Vector::Zero()}}, 0.02), "reading 1 of the drift is not finite");
    expect_says(message({}, 0), "it has to be positive");
    require_steady({}, 0.02);
}

TEST(Drift, AShiftComesFromThreeIndependentDatumTouches) {
    Random random(41);
    const Vector shift(0.01, -0.02, 0.005);
    std::vector<DatumOffset> offsets;
    for (const Vector& n : {Vector(1, 0, 0), Vector(0, 0.8, 0.6), Vector(0, 0, 1), Vector(0.6, 0, 0.8)})
        offsets.push_back({n, n.dot(shift)});
    EXPECT_NEAR((shift_of(offsets) - shift).norm(), 0, 1e-12);
    offsets.resize(3);
    EXPECT_NEAR((shift_of(offsets) - shift).norm(), 0, 1e-12);
    offsets[2].normal = Vector(0.01, 0.8, 0.6).normalized();
    expect_says(message_of<DriftError>([&] { static_cast<void>(shift_of(offsets)); }), "leave a direction open");
    offsets.resize(2);
    expect_says(message_of<DriftError>([&] { static_cast<void>(shift_of(offsets)); }), "leave a direction open");
}

}  // namespace
}  // namespace palpate::drift_test
