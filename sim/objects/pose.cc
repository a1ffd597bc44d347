#include "sim/objects/pose.h"

#include <Eigen/Geometry>

namespace palpate {

Pose make_pose(const Vector& rotate, const Point& at) {
    const auto turn = [](double angle, const Vector& axis) { return Eigen::AngleAxisd(angle, axis).toRotationMatrix(); };
    return {turn(rotate.z(), Vector::UnitZ()) * turn(rotate.y(), Vector::UnitY()) * turn(rotate.x(), Vector::UnitX()), at};
}

Pose operator*(const Pose& outer, const Pose& inner) {
    return {outer.rotation * inner.rotation, outer.rotation * inner.translation + outer.translation};
}

}  // namespace palpate
