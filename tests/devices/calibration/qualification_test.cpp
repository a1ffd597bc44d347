#include "devices/calibration/qualification.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/devices/calibration/sphere_device.h"
#include "tests/devices/message_of.h"

namespace palpate::qualification_test {
namespace {

constexpr double kResolution = 0.001;
const ReferenceSphere kReference{kSaidCenter, kSphere};

Qualification qualified(const SphereTouches& touches, const ReferenceSphere& sphere = kReference) {
    return qualify(touches, sphere, Vector::UnitZ(), kResolution);
}

SphereTouches touches_of(const Pretravel& pretravel, std::uint64_t seed, std::size_t count = 37, double sigma = kSigma) {
    Random random(seed);
    return synthetic_touches(pretravel, sigma, qualification_directions(Vector::UnitZ(), count), random);
}

QualificationError error_of(const SphereTouches& touches, const ReferenceSphere& sphere = kReference) {
    try {
        static_cast<void>(qualified(touches, sphere));
    } catch (const QualificationError& error) {
        return error;
    }
    ADD_FAILURE() << "nothing was thrown";
    return QualificationError("");
}

TEST(LobingMap, HarmonicsAreOrthonormalOverTheSphereAndToDegreesZeroAndOne) {
    // Gauss-Legendre would be exact; a grid in height and azimuth is to 1e-4.
    constexpr int kHeights = 400;
    constexpr int kAzimuths = 32;
    Eigen::Matrix<double, 16, 16> gram = Eigen::Matrix<double, 16, 16>::Zero();
    for (int i = 0; i < kHeights; ++i) {
        for (int j = 0; j < kAzimuths; ++j) {
            const double z = -1 + (i + 0.5) * 2 / kHeights;
            const double azimuth = 2 * std::numbers::pi * j / kAzimuths;
            const double flat = std::sqrt(1 - z * z);
            const Vector n(flat * std::cos(azimuth), flat * std::sin(azimuth), z);
            Eigen::Matrix<double, 16, 1> row;
            row.head<3>() = std::sqrt(3.0) * n;
            row[3] = 1;
            const auto harmonics = lobing_harmonics(n);
            for (std::size_t k = 0; k < 12; ++k) row[static_cast<Eigen::Index>(4 + k)] = harmonics[k];
            gram += row * row.transpose() / (kHeights * kAzimuths);
        }
    }
    EXPECT_LT((gram - Eigen::Matrix<double, 16, 16>::Identity()).cwiseAbs().maxCoeff(), 1e-3);
}

TEST(LobingMap, BelowTheEquatorItIsThatOfTheEquator) {
    LobingMap map;
    map.coefficients_mm = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
    for (auto& a : map.coefficients_mm) a /= 1000;
    const Vector flat = Vector(1, 2, 0).normalized();
    EXPECT_NEAR(map.pretravel((flat - 0.3 * Vector::UnitZ()).normalized()), map.pretravel(flat), 1e-12);
    EXPECT_TRUE(std::isfinite(map.pretravel(-Vector::UnitZ())));
    map.axis = -Vector::UnitZ();
    EXPECT_NE(map.pretravel((flat - 0.3 * Vector::UnitZ()).normalized()), map.pretravel(flat));
}

TEST(LobingMap, CorrectsAlongTheNormal) {
    LobingMap map;
    map.coefficients_mm[2] = 0.01;  // at the pole sqrt(5)
    const Point corrected = map.corrected(Point(1, 2, 3), Vector::UnitZ());
    EXPECT_NEAR((corrected - Point(1, 2, 3 - 0.01 * std::sqrt(5.0))).norm(), 0, 1e-12);
}

TEST(Qualification, ExactTouchesGiveCenterAndRadiusAndMapExactly) {
    Random random(1);
    const Qualification q =
        qualified(synthetic_touches(three_lobes, 0, qualification_directions(Vector::UnitZ(), 37), random, Vector::Zero()));
    EXPECT_NEAR((q.center - kSphereCenter).norm(), 0, 1e-8);
    EXPECT_LT(left_over(q, three_lobes).most, 1e-8);
    EXPECT_LT(q.rms_mm, 1e-9);
}

// What the centre misses along the axis shifts a part as a whole; it is told, and looked at by itself.
TEST(Qualification, LeavesLessThanThreeMicrometresOfKnownLobes) {
    constexpr std::uint64_t kSeeds = 200;
    for (const auto& [name, pretravel] : {std::pair<const char*, Pretravel>{"three lobes", three_lobes}, {"measured", measured_lobes}}) {
        for (const std::size_t count : {25U, 37U, 50U}) {
            LeftOver mean;
            double axial = 0;
            for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
                SCOPED_TRACE(seed_text(seed) + ", " + name + ", " + std::to_string(count) + " touches");
                const Qualification q = qualified(touches_of(pretravel, seed, count));
                const LeftOver left = left_over(q, pretravel);
                EXPECT_LE(left.shape_rms, 0.0015);
                EXPECT_LE(q.form_error_mm, 0.0045);
                EXPECT_GE(q.raw_form_error_mm, 0.008);
                EXPECT_NEAR(q.repeatability_mm, kSigma, 0.0004);
                EXPECT_EQ(q.residuals_mm.size(), count);
                const Vector off = q.center - kSphereCenter;
                EXPECT_LE(off.head<2>().norm(), 0.004);
                mean.rms += left.rms / kSeeds;
                mean.shape_rms += left.shape_rms / kSeeds;
                axial += off.z() * off.z() / kSeeds;
            }
            EXPECT_LE(std::sqrt(axial), 0.010);
            if (count == 50) {
                EXPECT_LE(mean.rms, 0.003) << "the shift of the whole counted";
            }
            EXPECT_LE(mean.shape_rms, 0.0008);
        }
    }
}

TEST(Qualification, DoesNotDependOnWhereTheCenterIsSaidToBe) {
    const SphereTouches touches = touches_of(measured_lobes, 3);
    const Qualification a = qualified(touches);
    const Qualification b = qualified(touches, {kSphereCenter + Vector(1, 2, -1), kSphere});
    EXPECT_NEAR((a.center - b.center).norm(), 0, 1e-8);
    for (std::size_t k = 0; k < LobingMap::kCoefficients; ++k) {
        EXPECT_NEAR(a.lobing.coefficients_mm[k], b.lobing.coefficients_mm[k], 1e-8);
    }
}

TEST(Qualification, NamesOutliersAndLeavesNoneOut) {
    SphereTouches touches = touches_of(three_lobes, 4);
    touches.touches[16].position += 0.03 * touches.touches[16].approach;
    const QualificationError one = error_of(touches);
    EXPECT_THAT(one.outliers(), testing::ElementsAre(16U));
    expect_says(one.what(), "touch 17 of 37 on the sphere does not fit to the others: clean ball and sphere");
    touches.touches[30].position -= 0.02 * touches.touches[30].approach;
    const QualificationError two = error_of(touches);
    EXPECT_THAT(two.outliers(), testing::ElementsAre(16U, 30U));
    expect_says(two.what(), "touches 17, 31 of 37");
}

TEST(Qualification, SeldomTakesNoiseForOutliers) {
    constexpr std::uint64_t kSeeds = 400;
    for (const std::size_t count : {25U, 37U}) {
        int refused = 0;
        for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
            try {
                static_cast<void>(qualified(touches_of(measured_lobes, seed, count)));
            } catch (const QualificationError& error) {
                ++refused;
            }
        }
        EXPECT_LE(refused, 3);
    }
}

TEST(Qualification, RefusesAMapThatLeavesMoreThanThreeTimesTheRepeatability) {
    const auto sharp = [](const Vector& n) { return sharp_lobes(n, 0.04); };
    const QualificationError error = error_of(touches_of(sharp, 5));
    EXPECT_TRUE(error.outliers().empty());
    expect_says(error.what(), "more than 3 times the");
    expect_says(error.what(), "tight and clean");
    // Cusps of a small range are within it.
    const auto blunt = [](const Vector& n) { return sharp_lobes(n, 0.006); };
    const Qualification q = qualified(touches_of(blunt, 5, 50));
    EXPECT_GT(q.rms_mm, kSigma);
    EXPECT_LE(left_over(q, blunt).shape_rms, 0.003);
}

TEST(Qualification, RefusesWhatItCannotBeSolvedFrom) {
    const SphereTouches good = touches_of(three_lobes, 6);
    expect_says(error_of(good, {kSaidCenter, 0}).what(), "the sphere's diameter is 0 mm, it has to be positive");
    expect_says(error_of(good, {kSaidCenter, -25}).what(), "has to be positive");
    expect_says(error_of(good, {kSaidCenter, std::numeric_limits<double>::quiet_NaN()}).what(), "has to be positive");
    expect_says(error_of(good, {kSaidCenter, 28}).what(), "28 mm is not the sphere's diameter");

    SphereTouches few = good;
    few.touches.resize(15);
    expect_says(error_of(few).what(), "15 touches of the sphere are too few for 16 unknowns: 25 at least");

    expect_says(message_of<QualificationError>([&] { static_cast<void>(qualify(good, kReference, Vector(0, 0, 2), kResolution)); }),
                "the tool's axis is no unit vector");

    SphereTouches single = good;
    for (auto& group : single.repeats) group.resize(1);
    expect_says(error_of(single).what(), "touched twice");

    SphereTouches broken = good;
    broken.touches[3].position.x() = std::numeric_limits<double>::infinity();
    expect_says(error_of(broken).what(), "touch 4 of the sphere has a number that is not finite");

    SphereTouches beside = good;
    beside.touches[8].approach = -beside.touches[8].approach;
    expect_says(error_of(beside).what(), "touch 9 of the sphere did not come along its normal");
}

TEST(Qualification, RefusesTouchesThatAreSpreadBadly) {
    // A cap of 50 degrees, and the pole with three rings: four heights would do, but not with the radius free.
    std::vector<Vector> cap = qualification_directions(Vector::UnitZ(), 37);
    for (Vector& n : cap) n = (n + 2 * Vector::UnitZ()).normalized();
    Random random(8);
    expect_says(error_of(synthetic_touches(three_lobes, kSigma, cap, random)).what(), "spread too badly");

    std::vector<Vector> one_ring = qualification_directions(Vector::UnitZ(), 37);
    for (Vector& n : one_ring) n = (Vector(n.x(), n.y(), 0) + Vector(1e-3, 0, 0)).normalized();
    expect_says(error_of(synthetic_touches(three_lobes, kSigma, one_ring, random)).what(), "spread too badly");
}

TEST(Qualification, RepeatabilityIsPooledOverGroups) {
    const auto at = [](double z) { return SphereTouch{Point(0, 0, z), -Vector::UnitZ()}; };
    EXPECT_NEAR(repeatability({{at(1), at(1.002)}, {at(5), at(5.004)}, {at(7)}}), std::sqrt((2e-6 + 8e-6) / 2), 1e-12);
}

TEST(FormError, IsTheRangeOfDistancesFromTheSphereThatFitsBest) {
    std::vector<SphereTouch> touches;
    const std::vector<Vector> iso = iso_directions(Vector::UnitZ());
    for (const Vector& n : iso) touches.push_back({Point(1, 2, 3) + 10 * n, -n});
    EXPECT_NEAR(form_error(touches, Point(1.2, 2, 3)), 0, 1e-9);
    // One that stands out draws the sphere a little.
    touches[7].position += 0.01 * iso[7];
    const double error = form_error(touches, Point(1.2, 2, 3));
    EXPECT_GT(error, 0.008);
    EXPECT_LT(error, 0.0101);
}

TEST(FitSphere, FindsTheCenter) {
    std::vector<SphereTouch> touches;
    for (const Vector& n : centering_directions(Vector::UnitZ())) touches.push_back({Point(1, 2, 3) + 10 * n, -n});
    const Ball ball = fit_sphere(touches, Point(1.5, 1.5, 3.2));
    EXPECT_NEAR((ball.center - Point(1, 2, 3)).norm(), 0, 1e-8);
    EXPECT_NEAR(ball.radius, 10, 1e-8);
    touches.resize(3);
    expect_says(message_of<QualificationError>([&] { static_cast<void>(fit_sphere(touches, Point::Zero())); }), "3 touches are too few");
}

TEST(LocateSphere, ShowsDriftToTheRepeatability) {
    const Qualification q = qualified(touches_of(three_lobes, 9));
    const std::vector<Vector> directions = centering_directions(Vector::UnitZ());
    const Vector drift(0.01, -0.02, 0.03);
    double most = 0;
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        Random random(seed);
        std::vector<SphereTouch> touches;
        for (const Vector& n : directions) {
            const double out = (kSphere + kBall) / 2 - three_lobes(n) - kSigma * gaussian(random);
            touches.push_back({kSphereCenter + drift + out * n, -n});
        }
        const Point center = locate_sphere(touches, kReference, q.effective_radius_mm, q.lobing);
        most = std::max(most, (center - q.center - drift).norm());
    }
    EXPECT_LE(most, 0.003);
}

}  // namespace
}  // namespace palpate::qualification_test
