#include "planner/part/internal/surface_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "planner/union_find.h"

namespace palpate {
namespace {

// Neighbours that the surface turns further away from are no graph over the tangent plane any more.
constexpr double kGraphTurn = 1.0;  // rad
// Fits of the same points in the frame that the last one gave; and how often points that lie off count less.
constexpr int kFits = 3;
// Of a neighbour's weight: over the mean distance of the first ring.
constexpr double kReach = 1.2;
// Of a residual that halves the weight: over that distance, where noise is less.
constexpr double kOutlier = 0.02;
// Of that distance: how far off a plane its points lie besides noise; how many there are at least, and of all; and their spread across over
// along.
constexpr double kFlat = 1e-3;
constexpr std::size_t kOnPlane = 6;
constexpr double kShareOnPlane = 0.45;
constexpr double kInRow = 0.1;
// mm per mm, and rad: how far off a surface goes on from one point to its neighbour.
constexpr double kExtrapolation = 0.03;
constexpr double kExact = 0.005;
// Of the former: farther off it is another surface.
constexpr double kFar = 3;
// Standard errors of the slope that the angle states.
constexpr double kSigmas = 2.5;

// rad: neighbours that disagree by more lie beyond an edge, which turns to them show.
constexpr double kMostDisagreement = 0.1;

struct Fan {
    Vector normal = Vector::Zero();  // weighted by angles, of one side of creases
    std::vector<std::uint32_t> facets;
    bool is_creased = false;
};

double corner_angle(const TriangleMesh& mesh, std::uint32_t facet, std::uint32_t v) {
    const auto& t = mesh.triangles[facet];
    const std::size_t k = t[0] == v ? 0 : t[1] == v ? 1 : 2;
    return angle_between(mesh.points[t[(k + 1) % 3]] - mesh.points[v], mesh.points[t[(k + 2) % 3]] - mesh.points[v]);
}

// The largest part of the fan that no concave crease cuts.
Fan side_of(const TriangleMesh& mesh, const std::vector<Vector>& normals, std::vector<std::uint32_t> fan, const std::vector<Sweep>& sweeps,
            std::uint32_t v) {
    const auto is_mixed = [&](std::uint32_t f) {
        return std::ranges::any_of(mesh.triangles[f], [&](auto w) { return sweeps[w] != sweeps[v]; });
    };
    const bool is_beside = std::ranges::any_of(fan, is_mixed);
    if (is_beside && !std::ranges::all_of(fan, is_mixed)) std::erase_if(fan, is_mixed);
    UnionFind sides(fan.size());
    for (std::size_t i = 0; i < fan.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            const auto& f = mesh.triangles[fan[i]];
            const auto& g = mesh.triangles[fan[j]];
            const auto is_shared = [&](std::uint32_t w) { return w != v && std::ranges::find(g, w) != g.end(); };
            if (std::ranges::none_of(f, is_shared)) continue;
            const auto other = std::ranges::find_if(g, [&](std::uint32_t w) { return std::ranges::find(f, w) == f.end(); });
            if (other == g.end()) continue;
            const Vector& n = normals[fan[i]];
            const bool is_concave = n.dot(mesh.points[*other] - mesh.points[v]) > 0;
            if (!is_concave || angle_between(n, normals[fan[j]]) < kCreaseAngle) sides.join(i, j);
        }
    }
    std::vector<double> angles(fan.size(), 0.0);
    for (std::size_t i = 0; i < fan.size(); ++i) angles[sides.root(i)] += corner_angle(mesh, fan[i], v);
    const auto largest = static_cast<std::size_t>(std::ranges::max_element(angles) - angles.begin());
    Fan side;
    for (std::size_t i = 0; i < fan.size(); ++i) {
        if (sides.root(i) != largest) continue;
        side.facets.push_back(fan[i]);
        side.normal += corner_angle(mesh, fan[i], v) * normals[fan[i]];
    }
    side.normal.normalize();
    side.is_creased = is_beside || side.facets.size() < fan.size();
    return side;
}

class Fitter {
public:
    Fitter(const TriangleMesh& mesh, const FacetFans& fans, const std::vector<Sweep>& sweeps, double noise)
        : mesh_(mesh), noise_(noise), fans_(mesh.points.size()) {
        std::vector<Vector> normals(mesh.triangles.size());
        for (std::uint32_t f = 0; f < normals.size(); ++f) normals[f] = facet_normal(mesh, f);
        for (std::uint32_t v = 0; v < fans_.size(); ++v) {
            const auto around = fans.around(v);
            fans_[v] = side_of(mesh, normals, {around.begin(), around.end()}, sweeps, v);
        }
    }

    [[nodiscard]] SurfaceFit fit(std::uint32_t v) const {
        SurfaceFit result{fans_[v].normal, std::numbers::pi / 2, fans_[v].is_creased};
        if (fans_[v].facets.empty()) return result;
        std::vector<std::uint32_t> around = ring(v);
        const double reach = mean_distance(v, around);
        const std::size_t first_ring = around.size();
        for (std::size_t k = 0; k < first_ring; ++k) {
            for (const std::uint32_t w : ring(around[k])) {
                if (w != v && belongs(v, w) && std::ranges::find(around, w) == around.end()) around.push_back(w);
            }
        }
        // A plane is worse than the fan where there are too few points.
        if (around.size() < kUnknowns || !(reach > 0)) {
            result.angle = 0.5;
            return result;
        }
        if (lies_on_plane(v, around, reach, result)) return result;
        for (int round = 0; round < kFits; ++round) improve(v, around, kReach * reach, result);
        // Residuals do not show where the curvature jumps; that the fan has another normal does.
        result.angle = std::max(result.angle, angle_between(result.normal, fans_[v].normal));
        return result;
    }

private:
    static constexpr int kUnknowns = 6;
    using Row = Eigen::Matrix<double, kUnknowns, 1>;
    using Matrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;

    // Do both lie on one side of creases, and see each other?
    [[nodiscard]] bool belongs(std::uint32_t v, std::uint32_t w) const {
        const Vector& n = fans_[v].normal;
        const Vector& m = fans_[w].normal;
        return angle_between(n, m) < kGraphTurn && !is_creased(mesh_.points[v], n, mesh_.points[w], m);
    }
    [[nodiscard]] std::vector<std::uint32_t> ring(std::uint32_t v) const {
        std::vector<std::uint32_t> found;
        for (const std::uint32_t f : fans_[v].facets) {
            for (const std::uint32_t w : mesh_.triangles[f]) {
                if (w != v && belongs(v, w) && std::ranges::find(found, w) == found.end()) found.push_back(w);
            }
        }
        return found;
    }
    [[nodiscard]] double mean_distance(std::uint32_t v, const std::vector<std::uint32_t>& around) const {
        double sum = 0;
        for (const std::uint32_t w : around) sum += (mesh_.points[w] - mesh_.points[v]).norm();
        return around.empty() ? 0 : sum / static_cast<double>(around.size());
    }

    // A plane through enough of the neighbours, beside which the surface may bend away: a quadric would lean there.
    [[nodiscard]] bool lies_on_plane(std::uint32_t v, const std::vector<std::uint32_t>& around, double reach, SurfaceFit& fit) const {
        const double slack = 1.2 * noise_ + kFlat * reach;
        const auto enough = std::max<std::size_t>(kOnPlane, static_cast<std::size_t>(kShareOnPlane * static_cast<double>(around.size())));
        for (const std::uint32_t f : fans_[v].facets) {
            Vector normal = facet_normal(mesh_, f);
            Point centre = mesh_.points[v];
            std::vector<Point> on;
            for (int round = 0; round < kFits; ++round) {
                on.assign(1, mesh_.points[v]);
                for (const std::uint32_t w : around) {
                    if (std::abs(normal.dot(mesh_.points[w] - centre)) <= slack) on.push_back(mesh_.points[w]);
                }
                if (on.size() < enough) break;
                centre = Point::Zero();
                for (const Point& p : on) centre += p / static_cast<double>(on.size());
                Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
                for (const Point& p : on) spread += (p - centre) * (p - centre).transpose();
                const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
                // In a row they say nothing of the plane.
                if (axes.eigenvalues()[1] < kInRow * axes.eigenvalues()[2]) {
                    on.clear();
                    break;
                }
                const Vector least = axes.eigenvectors().col(0);
                normal = least.dot(normal) < 0 ? Vector(-least) : least;
                const auto n = static_cast<double>(on.size());
                const double variance = std::max(axes.eigenvalues()[0] / std::max(n - 3, 1.0), noise_ * noise_ / 3);
                fit.angle = std::atan(kSigmas * std::sqrt(variance / axes.eigenvalues()[1]));
            }
            if (on.size() < enough || std::abs(normal.dot(mesh_.points[v] - centre)) > slack) continue;
            fit.normal = normal;
            fit.u = normal.unitOrthogonal();
            fit.w = normal.cross(fit.u);
            fit.quadric[0] = normal.dot(centre - mesh_.points[v]);
            fit.flatness = slack;
            return true;
        }
        return false;
    }

    // Heights over the tangent plane as a quadric, by weighted least squares, points that lie off it counting less.
    void improve(std::uint32_t v, const std::vector<std::uint32_t>& around, double reach, SurfaceFit& fit) const {
        const Vector u = fit.normal.unitOrthogonal();
        const Vector w = fit.normal.cross(u);
        std::vector<Row> rows;
        std::vector<double> heights;
        std::vector<double> weights;
        const auto add = [&](const Vector& to) {
            const double x = to.dot(u) / reach;
            const double y = to.dot(w) / reach;
            rows.emplace_back(Row(1, x, y, x * x / 2, x * y, y * y / 2));
            heights.push_back(to.dot(fit.normal));
            weights.push_back(std::exp(-to.squaredNorm() / (2 * reach * reach)));
        };
        add(Vector::Zero());
        for (const std::uint32_t k : around) add(mesh_.points[k] - mesh_.points[v]);
        const double outlier = std::max(2 * noise_, kOutlier * reach);
        std::vector<double> robust(rows.size(), 1.0);
        Row solution = Row::Zero();
        Matrix inverse = Matrix::Identity();
        double squares = 0;
        for (int round = 0; round < 2; ++round) {
            Matrix normal_matrix = 1e-9 * Matrix::Identity();
            Row right = Row::Zero();
            Matrix spread = Matrix::Zero();
            for (std::size_t k = 0; k < rows.size(); ++k) {
                const double weight = weights[k] * robust[k];
                normal_matrix += weight * rows[k] * rows[k].transpose();
                spread += weight * weight * rows[k] * rows[k].transpose();
                right += weight * heights[k] * rows[k];
            }
            const Eigen::LDLT<Matrix> factors(normal_matrix);
            solution = factors.solve(right);
            const Matrix half = factors.solve(Matrix::Identity());
            inverse = half * spread * half;
            squares = 0;
            double sum = 0;
            for (std::size_t k = 0; k < rows.size(); ++k) {
                const double off = heights[k] - rows[k].dot(solution);
                squares += weights[k] * robust[k] * off * off;
                sum += weights[k] * robust[k];
                robust[k] = 1 / (1 + off * off / (outlier * outlier));
            }
            // Six of the residuals' degrees of freedom are used up.
            const auto n = static_cast<double>(rows.size());
            squares *= n / (std::max(n - kUnknowns, 1.0) * sum);
        }
        const double variance = std::max(squares, noise_ * noise_ / 3);
        fit.angle = std::atan(kSigmas * std::sqrt(variance * (inverse(1, 1) + inverse(2, 2))) / reach);
        fit.normal = (fit.normal - (solution[1] * u + solution[2] * w) / reach).normalized();
        fit.u = u;
        fit.w = w;
        fit.quadric = solution;
        fit.quadric.segment<2>(1) /= reach;
        fit.quadric.tail<3>() /= reach * reach;
    }

    const TriangleMesh& mesh_;
    double noise_;
    std::vector<Fan> fans_;
};

struct Prediction {
    double off = 0.0;  // mm: how far the place lies above the surface
    Vector normal;     // of the surface there
};
// What a fit says of a place that is `to` away from its point.
Prediction predicted(const SurfaceFit& fit, const Vector& to) {
    const Vector up = fit.u.cross(fit.w);
    const double x = to.dot(fit.u);
    const double y = to.dot(fit.w);
    const auto& q = fit.quadric;
    const double height = q[0] + q[1] * x + q[2] * y + q[3] * x * x / 2 + q[4] * x * y + q[5] * y * y / 2;
    const Vector normal = (up - (q[1] + q[3] * x + q[4] * y) * fit.u - (q[2] + q[4] * x + q[5] * y) * fit.w).normalized();
    return {to.dot(up) - height, normal};
}

// Few points leave a fit no residuals, and what is finer than their distances shows in none: that fits of neighbours go on otherwise does.
void add_disagreement(std::vector<SurfaceFit>& fits, const TriangleMesh& mesh, const FacetFans& fans, const std::vector<Sweep>& sweeps) {
    std::vector<double> disagreements(fits.size(), 0.0);
    for (std::uint32_t v = 0; v < fits.size(); ++v) {
        double squares = 0;
        double count = 0;
        std::vector<std::uint32_t> ring;
        for (const std::uint32_t f : fans.around(v)) {
            for (const std::uint32_t j : mesh.triangles[f]) {
                if (j == v || std::ranges::find(ring, j) != ring.end()) continue;
                ring.push_back(j);
                if (fits[j].is_creased || sweeps[j] != sweeps[v] ||
                    is_creased(mesh.points[v], fits[v].normal, mesh.points[j], fits[j].normal))
                    continue;
                const Vector to = mesh.points[j] - mesh.points[v];
                const double here = angle_between(predicted(fits[j], -to).normal, fits[v].normal);
                const double there = fits[v].is_creased ? here : angle_between(predicted(fits[v], to).normal, fits[j].normal);
                squares += std::pow(std::min(here, kMostDisagreement), 2) + std::pow(std::min(there, kMostDisagreement), 2);
                count += 2;
            }
        }
        if (count > 0) disagreements[v] = std::sqrt(squares / count);
    }
    for (std::uint32_t v = 0; v < fits.size(); ++v) {
        // A plane has points to spare.
        if (!std::isfinite(fits[v].flatness)) fits[v].disagreement = disagreements[v];
    }
}

// Beside a crease a fan does not tell on which side of it the point lies: neighbours away from creases do, whose surface passes through it.
void choose_sides(std::vector<SurfaceFit>& fits, const TriangleMesh& mesh, const FacetFans& fans, const std::vector<Sweep>& sweeps,
                  double noise) {
    std::vector<std::pair<std::uint32_t, SurfaceFit>> chosen;
    for (std::uint32_t v = 0; v < fits.size(); ++v) {
        if (!fits[v].is_creased) continue;
        struct Candidate {
            double off = 0.0;    // mm: of the point from that surface
            double slack = 0.0;  // mm: what it may be
            double exact = 0.0;  // mm: what is as good as none, touch errors apart
            Vector normal;
            double angle = 0.0;
        };
        std::vector<Candidate> candidates;
        for (const std::uint32_t j : fans.two_rings(v)) {
            const SurfaceFit& fit = fits[j];
            if (fit.is_creased || sweeps[j] != sweeps[v]) continue;
            const Point& from = mesh.points[j];
            const double distance = (mesh.points[v] - from).norm();
            const auto [off, normal] = predicted(fit, mesh.points[v] - from);
            candidates.push_back({std::abs(off), 2 * noise + kExtrapolation * distance, kExact * distance, normal, fit.angle});
        }
        if (candidates.empty()) continue;
        const auto score = [](const Candidate& c) { return c.off + c.slack; };
        const Candidate& best = *std::ranges::min_element(candidates, {}, score);
        if (best.off > kFar * best.slack) continue;
        SurfaceFit fit = fits[v];
        fit.normal = best.normal;
        fit.angle = best.angle + kExtrapolation;
        // Unless the surface passes through it as well as touches tell, the fan may be right.
        if (best.off > 2 * noise + best.exact)
            fit.angle = std::max(fit.angle, std::min(angle_between(best.normal, fits[v].normal), kCreaseAngle));
        chosen.emplace_back(v, fit);
    }
    for (const auto& [v, fit] : chosen) fits[v] = fit;
}

}  // namespace

bool is_creased(const Point& a, const Vector& normal_a, const Point& b, const Vector& normal_b, double angle) {
    return (normal_b - normal_a).dot(b - a) < 0 && angle_between(normal_a, normal_b) > angle;
}

std::vector<SurfaceFit> fit_surface(const TriangleMesh& mesh, const FacetFans& fans, const std::vector<Sweep>& sweeps, double noise) {
    const Fitter fitter(mesh, fans, sweeps, noise);
    std::vector<SurfaceFit> fits(mesh.points.size());
    for (std::uint32_t v = 0; v < fits.size(); ++v) fits[v] = fitter.fit(v);
    choose_sides(fits, mesh, fans, sweeps, noise);
    add_disagreement(fits, mesh, fans, sweeps);
    return fits;
}

}  // namespace palpate
