#include "planner/loop/graze.h"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include "planner/errors.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

// Of ω's radius: far above rounding, far below anything that samples show.
constexpr double kBeside = 1e-7;
// A line moved by that meets a surface that it grazed within √(2 kBeside) of ω's radius, unless that bends less than ω.
constexpr double kNearGraze = 1e-3;

}  // namespace

void expect_graze(ProbeHead& head, const Crossing& touched, double radius) {
    const Vector way = (touched.near - touched.from).normalized();
    const Vector x = kBeside * radius * way.unitOrthogonal();
    const Vector y = way.cross(x);
    for (const Vector& aside : {Vector(Vector::Zero()), x, y, Vector(-x), Vector(-y)}) {
        head.go_to(touched.from_anchor);
        const ProbeHead::Answer answer = head.probe({touched.near + aside + x.norm() * way});
        if (answer.is_failed()) return;
        if (answer.is_contact() && (answer.position - touched.near).norm() <= kNearGraze * radius) return;
    }
    throw ContradictionError(
        fmt::format("S was touched at {} and is not there any more: the object moved, or that touch was false", point_text(touched.near)));
}

}  // namespace palpate
