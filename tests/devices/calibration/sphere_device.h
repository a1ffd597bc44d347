// A touch probe with lobes before an exact sphere.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "devices/calibration/touch_plan.h"
#include "devices/probe_device.h"
#include "tests/random.h"

namespace palpate {

inline double gaussian(Random& random) {
    const double radius = std::sqrt(-2 * std::log(random.uniform(1e-12, 1)));
    return radius * std::cos(random.uniform(0, 2 * std::numbers::pi));
}

// mm that the tool goes on after the ball has touched a surface with that outward normal, until the probe triggers.
using Pretravel = std::function<double(const Vector& normal)>;

// Around Z. 40 to 80 µm on the equator, three times, and 20 µm at the pole.
inline double three_lobes(const Vector& n) {
    return 0.02 + 0.04 * (n.x() * n.x() + n.y() * n.y()) - 0.02 * (n.x() * n.x() * n.x() - 3 * n.x() * n.y() * n.y());
}

// All of degrees 2 and 3, and about 1 µm of degree 4: 17 µm of range.
inline double measured_lobes(const Vector& n) {
    constexpr std::array<double, 12> kDegrees{0.9, -0.4, -2.1, 0.6, 1.2, 2.4, -0.5, 0.7, 0.8, -0.6, 0.4, 1.1};
    const std::array<double, 12> harmonics = lobing_harmonics(n);
    double sum = 30;
    for (std::size_t k = 0; k < kDegrees.size(); ++k) sum += kDegrees[k] * harmonics[k];
    const double x2 = n.x() * n.x();
    const double y2 = n.y() * n.y();
    const double z2 = n.z() * n.z();
    sum += x2 * x2 - 6 * x2 * y2 + y2 * y2 + 0.1 * (35 * z2 * z2 - 30 * z2 + 3);
    return sum / 1000;
}

// A kinematic seat without friction: the secant of the angle to the nearest of three, with its cusps. `range`: mm.
inline double sharp_lobes(const Vector& n, double range) {
    constexpr double kThird = 2 * std::numbers::pi / 3;
    const double azimuth = std::remainder(std::atan2(n.y(), n.x()), kThird);
    return range / std::cos(azimuth) * std::hypot(n.x(), n.y());
}

inline double no_lobes(const Vector&) { return 0; }

constexpr double kSigma = 0.0006;  // mm
constexpr double kBall = 2.0;      // mm, diameter
constexpr double kSphere = 25.0;
const Point kSphereCenter(40.3, -20.4, 10.1);
const Point kSaidCenter(40, -20, 10);  // 0.51 mm off

inline ToolShape test_tool() { return {kBall, ToolShape::Shaft{1.2, 40}, ToolShape::Shaft{40, 60}, Vector::UnitZ()}; }

// What a tool in that place touches of the sphere: nothing but the ball, or it is a fault of the way.
class SphereDevice final : public ProbeDevice {
public:
    struct Move {
        Point from;
        Point target;
        MoveResult result;
    };

    SphereDevice(Pretravel pretravel, const Point& start) : pretravel_(std::move(pretravel)), position_(start) {}

    [[nodiscard]] Point position() const override { return position_; }
    [[nodiscard]] MoveResult guarded_move(const Point& target, Pace pace) override {
        Move move{position_, target, {MoveResult::Outcome::reached, target}};
        if (pace == Pace::travel) ++fast_moves;
        const Vector way = target - position_;
        const double length = way.norm();
        std::optional<double> at = length > 0 ? triggered(way / length, length) : std::nullopt;
        if (script) at = script(move, at);
        position_ = target;
        if (at) {
            const Vector along = way / length;
            move.result = {MoveResult::Outcome::contact, move.from + *at * along};
            position_ = move.from + std::max(0.0, *at - kRetract) * along;
        }
        if (answer) answer(move.result);
        log.push_back(move);
        return move.result;
    }
    void stop() override {}

    // mm along the way, in place of what the sphere gives.
    std::function<std::optional<double>(const Move& move, std::optional<double> at)> script;
    std::function<void(MoveResult& result)> answer;  // changes it
    Point center = kSphereCenter;
    double diameter = kSphere;
    Random random{7};
    std::vector<Move> log;
    int fast_moves = 0;

private:
    static constexpr double kRetract = 0.5;

    std::optional<double> triggered(const Vector& along, double length) {
        const double distance = (diameter + kBall) / 2;
        const double nearest = (center - position_).dot(along);
        const double beside = (center - position_).squaredNorm() - nearest * nearest;
        if (beside >= distance * distance) return std::nullopt;
        const double touched = nearest - std::sqrt(distance * distance - beside);
        if (touched < 0) return std::nullopt;
        const Vector normal = (position_ + touched * along - center).normalized();
        const double at = touched + pretravel_(normal) + kSigma * gaussian(random);
        return at <= length ? std::optional(at) : std::nullopt;
    }

    Pretravel pretravel_;
    Point position_;
};

// Touches as a machine makes them once it has found the centre to within `off` (mm).
inline SphereTouches synthetic_touches(const Pretravel& pretravel, double sigma, const std::vector<Vector>& directions, Random& random,
                                       const Vector& off = Vector(0.03, -0.02, 0.04)) {
    const auto touch = [&](const Vector& n) -> SphereTouch {
        // Along the line to the centre that is believed in.
        const double distance = (kSphere + kBall) / 2;
        const double along = -off.dot(n);
        const double reach = along + std::sqrt(along * along + distance * distance - off.squaredNorm());
        const Vector normal = (off + reach * n).normalized();
        return {kSphereCenter + off + (reach - pretravel(normal) - sigma * gaussian(random)) * n, -n};
    };
    SphereTouches touches;
    for (const Vector& n : directions) touches.touches.push_back(touch(n));
    for (const std::size_t k : repeated_directions()) {
        touches.repeats.emplace_back();
        for (int again = 0; again < 5; ++again) touches.repeats.back().push_back(touch(directions[k]));
    }
    return touches;
}

// What radius and map leave of a touch's error along the normal, over the half that a stylus along Z reaches.
struct LeftOver {
    double rms = 0.0;        // mm
    double shape_rms = 0.0;  // mm: beside a shift of the whole
    double most = 0.0;
};

inline LeftOver left_over(const Qualification& q, const Pretravel& pretravel) {
    constexpr int kCount = 2000;
    Random random(99);
    Eigen::MatrixXd normals(kCount, 3);
    Eigen::VectorXd errors(kCount);
    for (int k = 0; k < kCount; ++k) {
        Vector n = random.direction();
        n.z() = std::abs(n.z());
        normals.row(k) = n;
        errors[k] = kBall / 2 - pretravel(n) - q.lobing.pretravel(n) - q.effective_radius_mm;
    }
    const Vector shift = (normals.transpose() * normals).ldlt().solve(normals.transpose() * errors);
    const auto rms = [&](const Eigen::VectorXd& of) { return std::sqrt(of.squaredNorm() / kCount); };
    return {rms(errors), rms(errors - normals * shift), errors.cwiseAbs().maxCoeff()};
}

}  // namespace palpate
