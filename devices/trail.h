// The ways that a session's tool has gone, from its journal. All of them are free, as the tool itself has shown.
#pragma once

#include <optional>
#include <vector>

#include "devices/journal.h"
#include "planner/geometry.h"

namespace palpate {

class Trail {
public:
    explicit Trail(const Journal& journal);

    // A shortest way over moves that were made, between two places where the tool rested: the points to pass after `from`, up to and
    // with `to`. Throws std::invalid_argument if the tool rested at neither.
    [[nodiscard]] std::vector<Point> way(const Point& from, const Point& to) const;

    // The move that passed nearest to `p`, if one did within `tolerance` (mm).
    [[nodiscard]] std::optional<Segment> move_near(const Point& p, double tolerance) const;

private:
    struct Link {
        std::size_t to = 0;
        double length = 0.0;
    };
    [[nodiscard]] std::size_t place_of(const Point& p) const;

    std::vector<Point> places_;             // in the order of the journal, each once
    std::vector<std::size_t> sorted_;       // their indices by coordinates, to find them
    std::vector<std::vector<Link>> links_;  // by place
};

[[nodiscard]] Point nearest_on(const Segment& segment, const Point& p);
// mm: from `p` to that point.
[[nodiscard]] double distance_to(const Segment& segment, const Point& p);

}  // namespace palpate
