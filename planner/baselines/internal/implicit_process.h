// A Gaussian process whose zero is a surface.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

// f is about the distance to S: 0 on S, negative inside (Williams and Fitzgibbon, "Gaussian process implicit surfaces", 2007). Its
// covariance is Matérn's with 3/2 and as long as the farthest two places are apart: nearly that of splines of r³, which have no length to
// choose. Thin plates' own, 2 r³ − 3 r² + 1, is no covariance in space: of 300 random places in a ball it has negative eigenvalues.
class ImplicitProcess {
public:
    // `bound`: contains all places that it is told and asked of.
    explicit ImplicitProcess(const Ball& bound) : bound_(bound) {}

    // mm: f at `p` is `value`, with that standard deviation. Quadratic time in what was added before.
    void add(const Point& p, double value, double error);

    [[nodiscard]] double mean(const Point& p) const;      // mm; linear time, but for the first after an add()
    [[nodiscard]] Vector gradient(const Point& p) const;  // of the mean, mm per mm
    // By place, of its own unit: 1 where nothing is known. Quadratic time for each.
    [[nodiscard]] std::vector<double> variances(const std::vector<Point>& places) const;

private:
    // Between that place and all observations; `p` in units of the process.
    [[nodiscard]] Eigen::ArrayXd covariances(const Point& p) const;
    [[nodiscard]] Point scaled(const Point& p) const { return (p - bound_.center) / (2 * bound_.radius); }
    [[nodiscard]] auto factor() const { return factor_.topLeftCorner(count_, count_); }
    void weigh() const;

    Ball bound_;
    Eigen::Index count_ = 0;
    Eigen::Matrix<double, Eigen::Dynamic, 3> places_;  // in rows; this and the next two with room for more than count_
    Eigen::MatrixXd factor_;                           // lower, of the covariance of all observations (Cholesky)
    Eigen::VectorXd whitened_;                         // factor⁻¹ · values
    mutable Eigen::VectorXd weights_;                  // covariance⁻¹ · values
    mutable Eigen::Index weighted_ = 0;                // observations that are in weights_
};

}  // namespace palpate
