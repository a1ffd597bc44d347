// A mesh as the text of an OFF file, with all digits.
#pragma once

#include <sstream>
#include <string>

#include "planner/geometry.h"

namespace palpate {

inline std::string off_text(const TriangleMesh& mesh) {
    std::ostringstream text;
    text.precision(17);
    text << "OFF\n" << mesh.points.size() << ' ' << mesh.triangles.size() << " 0\n";
    for (const Point& p : mesh.points) text << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
    for (const auto& [a, b, c] : mesh.triangles) text << "3 " << a << ' ' << b << ' ' << c << '\n';
    return text.str();
}

}  // namespace palpate
