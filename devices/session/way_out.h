// The shortest way out of the workspace over moves that a tool has made, looked for while it makes more.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <vector>

#include "planner/geometry.h"
#include "planner/surroundings.h"

namespace palpate {

class WayOut {
public:
    // The tool is at `start`. `surroundings` must outlive this.
    WayOut(const Surroundings& surroundings, const Point& start);

    // It went straight on to there.
    void add(const Point& rest);
    [[nodiscard]] const Point& place() const { return places_[at_]; }
    [[nodiscard]] bool is_outside() const { return is_outside_[at_]; }  // it is at a place outside ω or on its boundary
    [[nodiscard]] bool is_outside(const Point& p) const;
    // From where it is to a place outside ω or on its boundary: the points to pass, up to and with that place; none if it is at one. Throws
    // PositionLost if there is none. Time: n log n in the places nearer than that one.
    [[nodiscard]] std::vector<Point> way() const;

private:
    std::size_t index_of(const Point& p);

    const Surroundings& surroundings_;
    const double slack_;  // mm
    std::map<std::array<double, 3>, std::size_t> known_;
    std::vector<Point> places_;
    std::vector<bool> is_outside_;                 // by place
    std::vector<std::vector<std::size_t>> links_;  // by place
    std::size_t at_ = 0;
};

}  // namespace palpate
