#include "tools/view/internal/rasterizer.h"

namespace palpate {

Vector barycentric(const std::array<Screen, 3>& t, double x, double y) {
    const Screen p{x, y, 0.0};
    return Vector(doubled_area(p, t[1], t[2]), doubled_area(p, t[2], t[0]), doubled_area(p, t[0], t[1])) / doubled_area(t[0], t[1], t[2]);
}

}  // namespace palpate
