#include "tools/view/internal/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate {

namespace {

constexpr double kFieldOfView = 24.0 * std::numbers::pi / 180.0;  // a portrait lens

}  // namespace

Camera::Camera(const TriangleMesh& mesh, const PictureOptions& options) : perspective_(options.perspective) {
    toward_viewer_ = options.view_direction.normalized();
    right_ = options.up.cross(toward_viewer_).normalized();
    up_ = toward_viewer_.cross(right_);
    Eigen::AlignedBox3d box;
    for (const auto& triangle : mesh.triangles) {
        for (const auto i : triangle) {
            box.extend(mesh.points[i]);
        }
    }
    center_ = box.center();
    radius_ = box.diagonal().norm() / 2.0;
    eye_ = center_ + toward_viewer_ * radius_ / std::sin(kFieldOfView / 2.0);
    fit(mesh, options);
}

std::pair<Point, Vector> Camera::sight(double x, double y) const {
    const Vector across = ((x - shift_x_) * right_ - (y - shift_y_) * up_) / scale_;
    return perspective_ ? std::pair<Point, Vector>{eye_, across - toward_viewer_}
                        : std::pair<Point, Vector>{eye_ + across, -toward_viewer_};
}

void Camera::fit(const TriangleMesh& mesh, const PictureOptions& options) {
    Eigen::AlignedBox2d seen;
    for (const auto& triangle : mesh.triangles) {
        for (const auto i : triangle) {
            const Screen s = project(mesh.points[i]);
            seen.extend(Eigen::Vector2d(s.x, s.y));
        }
    }
    const double width = options.width_px * options.supersampling;
    const double height = options.height_px * options.supersampling;
    const Eigen::Vector2d extent = seen.sizes().cwiseMax(1e-12 * radius_);
    scale_ = (1.0 - 2.0 * options.margin) * std::min(width / extent.x(), height / extent.y());
    shift_x_ = width / 2.0 - scale_ * seen.center().x();
    shift_y_ = height / 2.0 - scale_ * seen.center().y();
}

}  // namespace palpate
