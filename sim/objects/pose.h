// Where something is put that has a frame of its own.
#pragma once

#include <Eigen/Core>

#include "planner/geometry.h"

namespace palpate {

struct Pose {
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // world from local
    Vector translation = Vector::Zero();                     // mm

    [[nodiscard]] Point to_local(const Point& p) const { return rotation.transpose() * (p - translation); }
    [[nodiscard]] Point to_world(const Point& p) const { return rotation * p + translation; }
};

// "About x, then y, then z of the fixed frame, before `at` is added" (sim/objects/object_spec.h).
[[nodiscard]] Pose make_pose(const Vector& rotate, const Point& at);
[[nodiscard]] Pose operator*(const Pose& outer, const Pose& inner);

}  // namespace palpate
