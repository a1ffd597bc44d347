// Where the viewer stands: from points in space to places on the screen and back.
#pragma once

#include <Eigen/Geometry>
#include <utility>

#include "planner/geometry.h"
#include "tools/view/internal/screen.h"
#include "tools/view/picture.h"

namespace palpate {

// It looks at the middle of the mesh, which fills the picture up to the margin.
class Camera {
public:
    Camera(const TriangleMesh& mesh, const PictureOptions& options);

    [[nodiscard]] Screen project(const Point& p) const {
        const Vector d = p - eye_;
        const double depth = -d.dot(toward_viewer_);
        const double w = perspective_ ? 1.0 / depth : 1.0;
        return {shift_x_ + scale_ * w * d.dot(right_), shift_y_ - scale_ * w * d.dot(up_), perspective_ ? w : -depth};
    }
    // Samples per millimetre at a point seen with this nearness.
    [[nodiscard]] double magnification(double nearness) const { return perspective_ ? scale_ * nearness : scale_; }
    [[nodiscard]] double nearness_at(double depth) const { return perspective_ ? 1.0 / depth : -depth; }
    [[nodiscard]] double depth_at(double nearness) const { return perspective_ ? 1.0 / nearness : -nearness; }
    // The weight that makes linear interpolation on the screen linear on the triangle.
    [[nodiscard]] double weight(const Screen& s) const { return perspective_ ? s.nearness : 1.0; }

    // A point of the line of sight through a place on the screen, and its direction.
    [[nodiscard]] std::pair<Point, Vector> sight(double x, double y) const;

    [[nodiscard]] const Vector& right() const { return right_; }
    [[nodiscard]] const Vector& up() const { return up_; }
    [[nodiscard]] const Vector& toward_viewer() const { return toward_viewer_; }
    [[nodiscard]] const Point& center() const { return center_; }
    [[nodiscard]] double radius() const { return radius_; }

private:
    // Moving and scaling the image plane is exact in both projections.
    void fit(const TriangleMesh& mesh, const PictureOptions& options);

    bool perspective_;
    Vector toward_viewer_, right_, up_;
    Point center_, eye_;
    double radius_ = 0.0;
    double scale_ = 1.0, shift_x_ = 0.0, shift_y_ = 0.0;
};

}  // namespace palpate
