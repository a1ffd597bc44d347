// What is told to a Gaussian process is what it says, and what is certain about it.
#include "planner/baselines/internal/implicit_process.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "tests/random.h"

namespace palpate::implicit_process_test {
namespace {

constexpr double kRadius = 3.0;
const Ball kBound{{1, -2, 0.5}, kRadius};

// Matérn's covariance with 3/2, from its definition.
double covariance(const Point& p, const Point& q) {
    const double r = std::sqrt(3.0) * (p - q).norm() / (2 * kRadius);
    return (1 + r) * std::exp(-r);
}

struct Told {
    std::vector<Point> places;
    std::vector<double> values;
    std::vector<double> errors;
};

Told tell(ImplicitProcess& process, std::size_t count, Random& random) {
    Told told;
    for (std::size_t k = 0; k < count; ++k) {
        const Point p = kBound.center + kRadius / 2 * Vector(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
        told.places.push_back(p);
        told.values.push_back(random.uniform(-1, 1));
        told.errors.push_back(random.uniform(0.05, 0.5));
        process.add(p, told.values.back(), told.errors.back());
    }
    return told;
}

TEST(ImplicitProcess, IsWhatTheFormulasSay) {
    Random random(7);
    ImplicitProcess process(kBound);
    EXPECT_EQ(process.mean(kBound.center), 0);
    const Told told = tell(process, 400, random);  // more than there was room for at first
    const auto n = static_cast<Eigen::Index>(told.places.size());
    Eigen::MatrixXd all(n, n);
    Eigen::VectorXd values(n);
    for (Eigen::Index i = 0; i < n; ++i) {
        const auto a = static_cast<std::size_t>(i);
        values(i) = told.values[a];
        for (Eigen::Index j = 0; j < n; ++j) all(i, j) = covariance(told.places[a], told.places[static_cast<std::size_t>(j)]);
        all(i, i) += std::pow(told.errors[a] / (2 * kRadius), 2);
    }
    const Eigen::MatrixXd inverse = all.inverse();
    for (int k = 0; k < 20; ++k) {
        const Point p = kBound.center + kRadius / 2 * Vector(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
        Eigen::VectorXd to_all(n);
        for (Eigen::Index i = 0; i < n; ++i) to_all(i) = covariance(p, told.places[static_cast<std::size_t>(i)]);
        EXPECT_NEAR(process.mean(p), to_all.dot(inverse * values), 1e-5);
        EXPECT_NEAR(process.variances({p})[0], 1 - to_all.dot(inverse * to_all), 1e-6);
        const double h = 1e-5;
        for (int axis = 0; axis < 3; ++axis) {
            const double slope = (process.mean(p + h * Vector::Unit(axis)) - process.mean(p - h * Vector::Unit(axis))) / (2 * h);
            EXPECT_NEAR(process.gradient(p)(axis), slope, 1e-4 * (1 + std::abs(slope)));
        }
    }
}

TEST(ImplicitProcess, IsCertainWhereItWasToldExactly) {
    Random random(8);
    ImplicitProcess process(kBound);
    const Point p = kBound.center + Vector(0.3, 0.2, -0.1);
    process.add(p, 0.25, 1e-6);
    double before = 1;
    for (int k = 0; k < 30; ++k) {
        tell(process, 1, random);
        const double elsewhere = process.variances({kBound.center + Vector(-1, 1, 1)})[0];
        EXPECT_LE(elsewhere, before + 1e-12) << "what is told makes nothing less certain";
        before = elsewhere;
    }
    EXPECT_NEAR(process.mean(p), 0.25, 1e-4);
    EXPECT_LT(process.variances({p})[0], 1e-8);
    process.add(p, 0.25, 1e-6);  // again: nothing breaks
    EXPECT_NEAR(process.mean(p), 0.25, 1e-4);
}

}  // namespace
}  // namespace palpate::implicit_process_test
