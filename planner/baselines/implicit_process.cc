#include "planner/baselines/internal/implicit_process.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate {
namespace {

// Of the prior variance: keeps the factor regular where places nearly coincide.
constexpr double kRegular = 1e-10;
constexpr double kRoot3 = std::numbers::sqrt3;
constexpr Eigen::Index kFirstRoom = 256;

}  // namespace

Eigen::ArrayXd ImplicitProcess::covariances(const Point& p) const {
    const auto places = places_.topRows(count_).array();
    const Eigen::ArrayXd scaled =
        kRoot3 * ((places.col(0) - p.x()).square() + (places.col(1) - p.y()).square() + (places.col(2) - p.z()).square()).sqrt();
    return (1 + scaled) * (-scaled).exp();
}

void ImplicitProcess::add(const Point& p, double value, double error) {
    if (count_ == places_.rows()) {
        const Eigen::Index room = std::max(kFirstRoom, 2 * count_);
        places_.conservativeResize(room, Eigen::NoChange);
        factor_.conservativeResize(room, room);
        whitened_.conservativeResize(room);
    }
    const double unit = 2 * bound_.radius;
    const Point place = scaled(p);
    const Eigen::VectorXd row = factor().triangularView<Eigen::Lower>().solve(covariances(place).matrix());
    const double rest = 1 + kRegular + error * error / (unit * unit) - row.squaredNorm();
    // Rounding, where a place is known already.
    const double pivot = std::sqrt(std::max(rest, kRegular));
    factor_.row(count_).head(count_) = row;
    factor_(count_, count_) = pivot;
    whitened_(count_) = (value / unit - row.dot(whitened_.head(count_))) / pivot;
    places_.row(count_) = place.transpose();
    ++count_;
}

void ImplicitProcess::weigh() const {
    if (weighted_ == count_) return;
    weights_ = factor().triangularView<Eigen::Lower>().adjoint().solve(whitened_.head(count_));
    weighted_ = count_;
}

double ImplicitProcess::mean(const Point& p) const {
    weigh();
    return 2 * bound_.radius * covariances(scaled(p)).matrix().dot(weights_);
}

Vector ImplicitProcess::gradient(const Point& p) const {
    weigh();
    const Point at = scaled(p);
    Vector sum = Vector::Zero();
    for (Eigen::Index k = 0; k < count_; ++k) {
        const Vector away = at - places_.row(k).transpose();
        sum -= weights_(k) * kRoot3 * kRoot3 * std::exp(-kRoot3 * away.norm()) * away;
    }
    return sum;
}

std::vector<double> ImplicitProcess::variances(const std::vector<Point>& places) const {
    Eigen::MatrixXd columns(count_, static_cast<Eigen::Index>(places.size()));
    for (Eigen::Index k = 0; k < columns.cols(); ++k) columns.col(k) = covariances(scaled(places[static_cast<std::size_t>(k)]));
    factor().triangularView<Eigen::Lower>().solveInPlace(columns);
    std::vector<double> variances;
    for (Eigen::Index k = 0; k < columns.cols(); ++k) variances.push_back(1 - columns.col(k).squaredNorm());
    return variances;
}

}  // namespace palpate
