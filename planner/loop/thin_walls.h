// Where O was found thinner than samples that are ε apart can show, and how near they have to be there.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <vector>

#include "planner/geometry.h"
#include "planner/loop/grid_cell.h"

namespace palpate {

// A wall shows where S was touched from both sides: at two places of one dual edge, or at two places near each other, in directions against
// each other. Samples tell the sides of a wall of thickness t apart where balls of facets are about as large as t: if all balls of a side
// have radii between s/√3 and s, a ball on one side that is free of samples of the other does not reach through once s² < s²/3 + t², and
// Voronoi faces, which are longer than edges, ask for somewhat less. So a wall asks for balls of kPerThickness · t, and of kSlope more for
// every millimetre away from it, as a sizing field (thesis 5.4) does. A wall that would ask for less than the finest spacing is not worth
// it: there balls of kSheet · ε are small enough to find how far it goes.
//
// May not live here: what is refined, and when (probing_loop.h).
class ThinWalls {
public:
    // mm: what no size exceeds, and the least that one may be.
    ThinWalls(double epsilon, double finest) : epsilon_(epsilon), finest_(finest) {}

    // Whether samples may come so near to each other that they tell the sides apart.
    [[nodiscard]] bool can_show(double thickness) const { return kPerThickness * thickness > finest_; }
    void note(const Point& middle, double thickness);
    // S was touched at p, coming along `direction` (unit).
    void note_touch(const Point& p, const Vector& direction);

    // mm, for the ball around p. Constant time: walls that others already imply are not kept. Beside a wall that samples cannot show, what
    // looks thicker nearby is not worth it either.
    [[nodiscard]] double size_at(const Point& p) const;
    // Whether a wall that samples cannot show is within that distance.
    [[nodiscard]] bool is_hopeless(const Point& p, double distance) const;

    // Measured on plates and tubes of 0.2 to 0.4 ε: with 1.2, 0.9, 0.7, 0.6 the walks without inference need 9.6, 9.0, 6.6, 5.9 probes per
    // sample on a plate, 12.7, 11.7, 9.3, 8.0 on a tube, and in all 22, 20, 16, 17 and 51, 47, 41, 42 thousand.
    static constexpr double kPerThickness = 0.6;
    static constexpr double kSlope = 0.5;
    static constexpr double kSheet = 0.5;

private:
    struct Wall {
        Point middle;
        double size;  // mm
        bool is_hopeless;
    };
    struct Touched {
        Point position;
        Vector direction;
    };
    [[nodiscard]] double sheet() const { return std::max(kSheet * epsilon_, finest_); }
    // So large that only neighbouring cells matter.
    [[nodiscard]] double cell_size() const { return epsilon_ / kSlope; }

    const double epsilon_;
    const double finest_;
    std::map<GridCell, std::vector<Wall>> walls_;       // in cells of cell_size()
    std::map<GridCell, std::vector<Touched>> touches_;  // in cells of epsilon
};

}  // namespace palpate
