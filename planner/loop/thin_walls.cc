#include "planner/loop/thin_walls.h"

#include <algorithm>

namespace palpate {
namespace {

// A wall that would make sizes smaller by less than this factor is not kept.
constexpr double kWorthKeeping = 0.8;
// Cosine of the angle between a touch's direction and the way to what was touched from the other side.
constexpr double kStraight = 0.85;

}  // namespace

void ThinWalls::note(const Point& middle, double thickness) {
    const bool is_hopeless = !can_show(thickness);
    const double size = is_hopeless ? sheet() : kPerThickness * thickness;
    const bool is_news = is_hopeless && !this->is_hopeless(middle, size);
    if (is_news || size < kWorthKeeping * size_at(middle)) walls_[grid_cell(middle, cell_size())].push_back({middle, size, is_hopeless});
}

void ThinWalls::note_touch(const Point& p, const Vector& direction) {
    const auto at = grid_cell(p, epsilon_);
    visit_near(touches_, at, [&](const Touched& other) {
        const Vector through = other.position - p;
        const double thickness = through.norm();
        if (kPerThickness * thickness > epsilon_) return;
        if (through.dot(direction) < kStraight * thickness || through.dot(other.direction) > -kStraight * thickness) return;
        if (can_show(thickness)) note((p + other.position) / 2, thickness);
    });
    touches_[at].push_back({p, direction});
}

double ThinWalls::size_at(const Point& p) const {
    double size = epsilon_;
    if (walls_.empty()) return size;
    bool is_hopeless = false;
    visit_near(walls_, grid_cell(p, cell_size()), [&](const Wall& wall) {
        const double distance = (p - wall.middle).norm();
        size = std::min(size, wall.size + kSlope * distance);
        is_hopeless |= wall.is_hopeless && distance < wall.size;
    });
    return is_hopeless ? std::max(size, sheet()) : size;
}

bool ThinWalls::is_hopeless(const Point& p, double distance) const {
    bool is_near = false;
    visit_near(walls_, grid_cell(p, cell_size()),
               [&](const Wall& wall) { is_near |= wall.is_hopeless && (p - wall.middle).norm() <= distance; });
    return is_near;
}

}  // namespace palpate
