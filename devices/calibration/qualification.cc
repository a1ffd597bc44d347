#include "devices/calibration/qualification.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace palpate {
namespace {

// Columns of equal length; the plan's touches have some 40 (touch_plan.cc), ...
constexpr double kMostCondition = 400.0;
// ... and what lies that many standard deviations beside the fit of the others is no noise: with 9 degrees of freedom, the fewest, once in
// 5,000 touches by chance.
constexpr double kOutlier = 6.0;
// So many of the touches are looked for outliers: what is worse has another reason.
constexpr std::size_t kMostOutliersShare = 5;
// cos 25 degrees. A sphere whose centre is not where it was said to be, seen from a start beside it.
constexpr double kLeastApproach = 0.9;
constexpr int kMostTurns = 50;
constexpr double kSettled_mm = 1e-9;
constexpr double kNothing = 1e-12;
constexpr double kRounding = 1e-9;  // of unit vectors

using Row = Eigen::RowVectorXd;

// What is not known besides the centre: nothing, the radius, or that and the lobes.
enum class Model { center, sphere, lobes };

Eigen::Index unknowns_of(Model model) {
    constexpr auto kAll = static_cast<Eigen::Index>(kQualificationUnknowns);
    return model == Model::center ? 3 : model == Model::sphere ? 4 : kAll;
}

Row row_of(const Vector& n, Model model) {
    Row row(unknowns_of(model));
    row.head<3>() = n;
    if (model == Model::center) return row;
    row[3] = 1;
    if (model == Model::sphere) return row;
    const auto harmonics = lobing_harmonics(n);
    for (std::size_t k = 0; k < harmonics.size(); ++k) row[static_cast<Eigen::Index>(4 + k)] = harmonics[k];
    return row;
}

struct Fit {
    Point center = Point::Zero();
    Eigen::VectorXd shape;      // mm: mean distance, then the map's coefficients
    Eigen::VectorXd residuals;  // mm
    Eigen::VectorXd leverages;  // 0 to 1: how far a touch draws the fit to itself
    Eigen::Matrix3d spread;     // of the centre: its covariance, for touches with a standard deviation of 1
    double condition = 0.0;
};

// Gauss-Newton in the centre; all else is linear. `radius`: mm, of what Model::center has to know; 0 otherwise.
Fit fit(const std::vector<Point>& points, const Point& about_center, Model model, double radius = 0.0) {
    const auto count = static_cast<Eigen::Index>(points.size());
    const Eigen::Index unknowns = unknowns_of(model);
    Fit fit;
    fit.center = about_center;
    Eigen::MatrixXd a(count, unknowns);
    Eigen::VectorXd distances(count);
    for (int turn = 0; turn < kMostTurns; ++turn) {
        for (Eigen::Index k = 0; k < count; ++k) {
            const Vector out = points[static_cast<std::size_t>(k)] - fit.center;
            distances[k] = out.norm() - radius;
            a.row(k) = row_of(out.normalized(), model);
        }
        const Eigen::VectorXd scale = a.colwise().norm().cwiseMax(kNothing).cwiseInverse();
        const Eigen::JacobiSVD<Eigen::MatrixXd> svd(a * scale.asDiagonal(), Eigen::ComputeThinU | Eigen::ComputeThinV);
        const Eigen::VectorXd& values = svd.singularValues();
        fit.condition = values[0] / std::max(values[unknowns - 1], kNothing);
        if (!(fit.condition <= kMostCondition)) {
            throw QualificationError(fmt::format(
                "the touches are spread too badly over the sphere to show what is asked of them (condition number {:.3g}, at most {:.0f} "
                "is good): touch all of the half that the stylus reaches, from the pole to the equator",
                fit.condition, kMostCondition));
        }
        const Eigen::VectorXd x = svd.solve(distances).cwiseProduct(scale);
        fit.center += x.head<3>();
        if (!(x.head<3>().norm() < kSettled_mm)) continue;
        const Eigen::MatrixXd roots = (scale.asDiagonal() * svd.matrixV() * values.cwiseInverse().asDiagonal()).topRows<3>();
        fit.spread = roots * roots.transpose();
        fit.residuals = distances - a * x;
        fit.leverages = svd.matrixU().rowwise().squaredNorm();
        fit.shape = x.tail(unknowns - 3);
        return fit;
    }
    throw QualificationError(
        "no sphere fits to the touches: its centre is not about where it was said to be, or they are of something else");
}

void require_finite(const std::vector<SphereTouch>& touches) {
    for (std::size_t k = 0; k < touches.size(); ++k) {
        if (!touches[k].position.allFinite() || !touches[k].approach.allFinite()) {
            throw QualificationError(fmt::format("touch {} of the sphere has a number that is not finite", k + 1));
        }
    }
}

std::vector<Point> positions(const std::vector<SphereTouch>& touches) {
    std::vector<Point> points;
    points.reserve(touches.size());
    for (const SphereTouch& touch : touches) points.push_back(touch.position);
    return points;
}

void require_approaches(const std::vector<SphereTouch>& touches, const Point& center) {
    for (std::size_t k = 0; k < touches.size(); ++k) {
        const Vector inwards = (center - touches[k].position).normalized();
        if (touches[k].approach.normalized().dot(inwards) >= kLeastApproach) continue;
        throw QualificationError(fmt::format(
            "touch {} of the sphere did not come along its normal: say where the sphere's centre is, and approach it straight", k + 1));
    }
}

// Those that the others contradict, the worst first, each judged by a fit without it and those before. `sigma`: mm, the least that counts.
std::vector<std::size_t> outliers_of(const std::vector<Point>& points, const Point& about_center, double sigma) {
    std::vector<std::size_t> kept(points.size());
    std::iota(kept.begin(), kept.end(), std::size_t{0});
    std::vector<std::size_t> outliers;
    while (outliers.size() <= points.size() / kMostOutliersShare && kept.size() > kQualificationUnknowns + 1) {
        std::vector<Point> left;
        left.reserve(kept.size());
        for (const std::size_t k : kept) left.push_back(points[k]);
        const Fit all = fit(left, about_center, Model::lobes);
        const double squares = all.residuals.squaredNorm();
        const auto freedom = static_cast<double>(kept.size() - kQualificationUnknowns - 1);
        std::size_t worst = 0;
        double most = 0;
        for (std::size_t k = 0; k < kept.size(); ++k) {
            const auto row = static_cast<Eigen::Index>(k);
            // The externally studentised residual (Belsley, Kuh, Welsch 1980).
            const double alone = std::max(1 - all.leverages[row], 1e-6);
            const double own = all.residuals[row] * all.residuals[row] / alone;
            const double others = std::sqrt(std::max(squares - own, 0.0) / freedom);
            const double off = std::sqrt(own) / std::max(others, sigma);
            if (off <= most) continue;
            most = off;
            worst = k;
        }
        if (most <= kOutlier) break;
        outliers.push_back(kept[worst]);
        kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(worst));
    }
    return outliers;
}

[[noreturn]] void refuse_outliers(std::vector<std::size_t> outliers, std::size_t count) {
    std::ranges::sort(outliers);
    std::string numbers;
    for (const std::size_t k : outliers) numbers += fmt::format("{}{}", numbers.empty() ? "" : ", ", k + 1);
    const bool is_one = outliers.size() == 1;
    const std::string message =
        fmt::format("{} {} of {} on the sphere {} not fit to the others: clean ball and sphere, see that both are tight, and touch again",
                    is_one ? "touch" : "touches", numbers, count, is_one ? "does" : "do");
    throw QualificationError(message, std::move(outliers));
}

void require_sense(const SphereTouches& touches, const ReferenceSphere& sphere, const Vector& axis) {
    if (!(sphere.diameter > 0) || !std::isfinite(sphere.diameter)) {
        throw QualificationError(fmt::format("the sphere's diameter is {} mm, it has to be positive", sphere.diameter));
    }
    if (!sphere.center.allFinite()) throw QualificationError("the sphere's centre is not finite");
    if (!(std::abs(axis.norm() - 1) <= kRounding)) throw QualificationError("the tool's axis is no unit vector");
    if (touches.touches.size() < kIsoTouches) {
        throw QualificationError(fmt::format("{} touches of the sphere are too few for {} unknowns: {} at least", touches.touches.size(),
                                             kQualificationUnknowns, kIsoTouches));
    }
    require_finite(touches.touches);
    for (const auto& group : touches.repeats) require_finite(group);
}

}  // namespace

double repeatability(const std::vector<std::vector<SphereTouch>>& groups) {
    double squares = 0;
    std::size_t freedom = 0;
    for (const auto& group : groups) {
        if (group.size() < 2) continue;
        double mean = 0;
        for (const SphereTouch& touch : group) mean += touch.position.dot(group.front().approach) / static_cast<double>(group.size());
        for (const SphereTouch& touch : group) squares += std::pow(touch.position.dot(group.front().approach) - mean, 2);
        freedom += group.size() - 1;
    }
    if (freedom == 0) throw QualificationError("no place of the sphere was touched twice: how well the probe repeats is not known");
    return std::sqrt(squares / static_cast<double>(freedom));
}

Ball fit_sphere(const std::vector<SphereTouch>& touches, const Point& about_center) {
    if (touches.size() < 4) throw QualificationError(fmt::format("{} touches are too few for a sphere: 4 at least", touches.size()));
    require_finite(touches);
    const Fit sphere = fit(positions(touches), about_center, Model::sphere);
    return {sphere.center, sphere.shape[0]};
}

double form_error(const std::vector<SphereTouch>& touches, const Point& about_center, const LobingMap& map) {
    if (touches.size() < 5) throw QualificationError(fmt::format("{} touches are too few for a form error", touches.size()));
    require_finite(touches);
    std::vector<Point> points = positions(touches);
    const Point center = fit(points, about_center, Model::sphere).center;
    for (Point& p : points) p = map.corrected(p, (p - center).normalized());
    const Fit sphere = fit(points, about_center, Model::sphere);
    return sphere.residuals.maxCoeff() - sphere.residuals.minCoeff();
}

Point locate_sphere(const std::vector<SphereTouch>& touches, const ReferenceSphere& sphere, double effective_radius_mm,
                    const LobingMap& map) {
    const Ball about = fit_sphere(touches, sphere.center);
    std::vector<Point> points = positions(touches);
    for (Point& p : points) p = map.corrected(p, (p - about.center).normalized());
    return fit(points, about.center, Model::center, sphere.diameter / 2 + effective_radius_mm).center;
}

Qualification qualify(const SphereTouches& touches, const ReferenceSphere& sphere, const Vector& axis, double resolution_mm) {
    require_sense(touches, sphere, axis);
    const std::vector<Point> points = positions(touches.touches);
    Qualification result;
    result.repeatability_mm = repeatability(touches.repeats);
    const double sigma = std::max(result.repeatability_mm, resolution_mm / std::sqrt(12.0));

    const Fit lobes = fit(points, sphere.center, Model::lobes);
    require_approaches(touches.touches, lobes.center);
    if (std::vector<std::size_t> outliers = outliers_of(points, sphere.center, sigma); !outliers.empty()) {
        refuse_outliers(std::move(outliers), points.size());
    }
    result.rms_mm = std::sqrt(lobes.residuals.squaredNorm() / static_cast<double>(points.size() - kQualificationUnknowns));
    if (result.rms_mm > kMostMisfit * sigma) {
        throw QualificationError(
            fmt::format("the probe's map leaves {:.4f} mm (RMS) of the touches, more than {:.0f} times the {:.4f} mm that repeated touches "
                        "scatter by: see "
                        "that sphere and stylus are tight and clean; a probe whose lobes are that sharp has no map",
                        result.rms_mm, kMostMisfit, sigma));
    }
    result.center = lobes.center;
    result.condition = lobes.condition;
    result.axial_sigma_mm = result.rms_mm * std::sqrt(axis.dot(lobes.spread * axis));
    result.effective_radius_mm = lobes.shape[0] - sphere.diameter / 2;
    if (!(result.effective_radius_mm > 0)) {
        throw QualificationError(fmt::format("the ball would have a radius of {:.3f} mm: {} mm is not the sphere's diameter",
                                             result.effective_radius_mm, sphere.diameter));
    }
    for (std::size_t k = 0; k < LobingMap::kCoefficients; ++k) {
        result.lobing.coefficients_mm[k] = lobes.shape[static_cast<Eigen::Index>(1 + k)];
    }
    result.lobing.axis = axis;
    result.residuals_mm.assign(lobes.residuals.begin(), lobes.residuals.end());
    const std::vector<SphereTouch> iso(touches.touches.begin(), touches.touches.begin() + kIsoTouches);
    result.form_error_mm = form_error(iso, lobes.center, result.lobing);
    result.raw_form_error_mm = form_error(iso, lobes.center);
    return result;
}

}  // namespace palpate
