#include "planner/curved/internal/local_spline.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate {
namespace {

// In units of the scale.
constexpr double kOffset = 0.3;  // of the points beside touches. planner/curved/README.md has what others do
// The ridge of points beside touches, whose normals are estimated, and of touches that do not err: none but rounding's.
constexpr double kNormalRidge = 0.03;
constexpr double kLeastRidge = 1e-9;
// A function of the kind that surfaces need has a standard deviation of that much from a plane at a distance of 1. With it a touch error
// of σ is a ridge of (σ / kRoughness)².
constexpr double kRoughness = 0.01;
// An error is about so many standard deviations.
constexpr double kDeviations = 3.0;
// Fewer touches do not tell a quadric.
constexpr std::size_t kFewestForQuadric = 14;
// Cosine of 60°: where normals turn by more, a quadric is no better than a plane, and on coarse tori worse by half.
constexpr double kMostTurnOfQuadric = 0.5;
// Touches of a larger error are left to their neighbours.
constexpr double kMostRidge = 1e3;

double ridge_of(double error) { return std::clamp(std::pow(error / (kDeviations * kRoughness), 2), kLeastRidge, kMostRidge); }

// By row the values of 1, x, y, z and, of ten, x²/2, y²/2, z²/2, xy, xz, yz.
Eigen::MatrixXd polynomials(const Eigen::Array<double, Eigen::Dynamic, 3>& at, Eigen::Index count) {
    Eigen::MatrixXd p(at.rows(), count);
    p.col(0).setOnes();
    p.middleCols<3>(1) = at.matrix();
    if (count == 4) return p;
    p.middleCols<3>(4) = (at.square() / 2).matrix();
    p.col(7) = (at.col(0) * at.col(1)).matrix();
    p.col(8) = (at.col(0) * at.col(2)).matrix();
    p.col(9) = (at.col(1) * at.col(2)).matrix();
    return p;
}

// By how much the first touch is off what is predicted without the first `count` rows. Of the inverse K⁻¹ of the system the columns have
// K⁻¹ wanted and K⁻¹'s first columns: without the rows B the residual there is (K⁻¹_BB)⁻¹ (K⁻¹ wanted)_B.
double left_out(const Eigen::MatrixXd& columns, Eigen::Index count) {
    const Eigen::MatrixXd block = columns.block(0, 1, count, count);
    const Eigen::FullPivLU<Eigen::MatrixXd> solver(block);
    if (!solver.isInvertible()) return std::numeric_limits<double>::infinity();
    const double residual = std::abs(solver.solve(columns.col(0).head(count))[0]);
    return std::isfinite(residual) ? residual : std::numeric_limits<double>::infinity();
}

}  // namespace

std::optional<LocalSpline> LocalSpline::fit(std::span<const Site> sites, std::size_t near, double scale, Trend trend) {
    if (sites.size() < kFewestSites || sites.size() > kMostSites || !(scale > 0)) return std::nullopt;
    LocalSpline s;
    s.origin_ = sites.front().point;
    s.scale_ = scale;
    Eigen::Index n = 0;
    Eigen::Index rows = 0;  // of the near touches
    for (std::size_t i = 0; i < sites.size(); ++i) {
        n += sites[i].has_normal ? 3 : 1;
        if (i < near) rows = n;
    }
    s.centres_.resize(n, 3);
    Eigen::VectorXd wanted(n);
    Eigen::VectorXd ridge(n);
    Eigen::Index row = 0;
    for (const Site& site : sites) {
        const Vector at = (site.point - s.origin_) / scale;
        const double touch = ridge_of(site.error / scale);
        for (const double off : {0.0, kOffset, -kOffset}) {
            if (off != 0 && !site.has_normal) continue;
            s.centres_.row(row) = (at + off * site.normal).transpose().array();
            wanted[row] = off;
            ridge[row] = off == 0 ? touch : touch + kNormalRidge;
            ++row;
        }
    }
    // [A P; Pᵀ 0] [c; d] = [wanted; 0], A positive definite on what P does not see: Q turns P into a triangle, and what is left is solved
    // by Cholesky.
    Eigen::MatrixXd a(n, n);
    for (Eigen::Index j = 0; j < n; ++j) {
        const auto squared = (s.centres_.rowwise() - s.centres_.row(j)).square().rowwise().sum().eval();
        a.col(j) = (squared * squared.sqrt()).matrix();
    }
    a.diagonal() += ridge;
    const bool bends = trend == Trend::quadric && sites.size() >= kFewestForQuadric && std::ranges::all_of(sites, [&](const Site& site) {
                           return site.normal.dot(sites.front().normal) > kMostTurnOfQuadric;
                       });
    const Eigen::MatrixXd p = polynomials(s.centres_, bends ? 10 : 4);
    const Eigen::Index q = p.cols();
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(p);
    const Eigen::MatrixXd r = qr.matrixQR().topRows(q).triangularView<Eigen::Upper>();
    if (r.diagonal().cwiseAbs().minCoeff() < 1e-6) return std::nullopt;
    a.applyOnTheLeft(qr.householderQ().adjoint());
    a.applyOnTheRight(qr.householderQ());
    const Eigen::Index m = n - q;
    const Eigen::LLT<Eigen::MatrixXd> solver(a.bottomRightCorner(m, m));
    if (solver.info() != Eigen::Success) return std::nullopt;
    // The columns besides are what the inverse of the whole does to the rows of the near touches: it tells what is predicted without them.
    Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(n, 1 + rows);
    columns.col(0) = wanted;
    for (Eigen::Index k = 0; k < rows; ++k) columns(k, 1 + k) = 1;
    columns.applyOnTheLeft(qr.householderQ().adjoint());
    const Eigen::VectorXd top = columns.col(0).head(q);
    columns.bottomRows(m) = solver.solve(columns.bottomRows(m));
    columns.topRows(q).setZero();
    const Eigen::VectorXd d = r.triangularView<Eigen::Upper>().solve(top - a.topRightCorner(q, m) * columns.col(0).tail(m));
    s.plane_ = d.head<4>();
    if (q == 10) s.quadric_ << d[4], d[7], d[8], d[7], d[5], d[9], d[8], d[9], d[6];
    columns.applyOnTheLeft(qr.householderQ());
    s.weights_ = columns.col(0).array();
    s.surprise_ = scale * left_out(columns, 3);
    s.far_surprise_ = scale * left_out(columns, rows);
    if (!s.weights_.allFinite() || !s.plane_.allFinite()) return std::nullopt;
    return s;
}

LocalSpline::Jet LocalSpline::jet(const Point& p) const {
    const Vector x = (p - origin_) / scale_;
    const Column dx = x[0] - centres_.col(0);
    const Column dy = x[1] - centres_.col(1);
    const Column dz = x[2] - centres_.col(2);
    const Column squared = dx.square() + dy.square() + dz.square();
    const Column slope = weights_ * squared.sqrt();
    const Vector gradient = plane_.tail<3>() + quadric_ * x + 3 * Vector((slope * dx).sum(), (slope * dy).sum(), (slope * dz).sum());
    return {(plane_[0] + plane_.tail<3>().dot(x) + x.dot(quadric_ * x) / 2 + (slope * squared).sum()) * scale_, gradient};
}

LocalSpline::SecondJet LocalSpline::second_jet(const Point& p) const {
    // Of |d|³: 3 |d| I + 3 d dᵀ / |d|; that is 0 where d is.
    constexpr double kNoLength = 1e-100;
    const Vector x = (p - origin_) / scale_;
    const Column dx = x[0] - centres_.col(0);
    const Column dy = x[1] - centres_.col(1);
    const Column dz = x[2] - centres_.col(2);
    const Column squared = dx.square() + dy.square() + dz.square();
    const Column length = squared.sqrt();
    const Column slope = weights_ * length;
    const Column share = weights_ / (length + kNoLength);
    SecondJet all;
    all.value = (plane_[0] + plane_.tail<3>().dot(x) + x.dot(quadric_ * x) / 2 + (slope * squared).sum()) * scale_;
    all.gradient = plane_.tail<3>() + quadric_ * x + 3 * Vector((slope * dx).sum(), (slope * dy).sum(), (slope * dz).sum());
    const double xy = (share * dx * dy).sum();
    const double xz = (share * dx * dz).sum();
    const double yz = (share * dy * dz).sum();
    all.hessian << (share * dx.square()).sum(), xy, xz, xy, (share * dy.square()).sum(), yz, xz, yz, (share * dz.square()).sum();
    all.hessian.diagonal().array() += slope.sum();
    all.hessian = (3 * all.hessian + quadric_) / scale_;
    return all;
}

}  // namespace palpate
