// The ways that a session's tool has gone, from its journal. All of them are free, as the tool itself has shown.
#pragma once

#include <optional>
#include <vector>

#include "devices/session/journal.h"
#include "planner/geometry.h"
#include "planner/surroundings.h"

namespace palpate {

class VisitedWays {
public:
    // A place that was touched although moves had passed it: of those from the `first` to before the `last`, none that passes within
    // `tolerance` (mm) counts.
    struct Contradiction {
        Point touched = Point::Zero();
        double tolerance = 0.0;
        std::size_t first = 0;
        std::size_t last = 0;
    };
    // Places in free surroundings are joined by ways through them.
    VisitedWays(const Journal& journal, const Surroundings& surroundings, const std::vector<Contradiction>& contradictions = {});

    // A shortest way over moves that were made and around the workspace, between two places where the tool rested: the points to pass after
    // `from`, up to and with `to`. Throws std::invalid_argument if the tool rested at neither, PositionLost if
    // no way is left.
    [[nodiscard]] std::vector<Point> way(const Point& from, const Point& to) const;
    // Whether the tool rested at both, and a way is left.
    [[nodiscard]] bool has_way(const Point& from, const Point& to) const;
    // mm: the lengths of such ways (those that came after the last contact count far more) from a place to each of several; infinite where
    // the tool never rested.
    [[nodiscard]] std::vector<double> lengths(const Point& from, const std::vector<Point>& to) const;

    // The move that passed nearest to `p`, if one did within `tolerance` (mm).
    [[nodiscard]] std::optional<Segment> move_near(const Point& p, double tolerance) const;

private:
    struct Link {
        std::size_t to = 0;
        double length = 0.0;  // mm, or more where nothing confirms it
    };
    // Shortest ways from everywhere to one place.
    struct Ways {
        std::vector<double> cost;       // mm, by place
        std::vector<std::size_t> next;  // on the way there
    };
    [[nodiscard]] std::optional<std::size_t> find(const Point& p) const;
    [[nodiscard]] std::size_t place_of(const Point& p) const;
    // All of them, or as far as one place needs.
    [[nodiscard]] Ways ways_to(std::size_t goal, std::optional<std::size_t> start) const;
    [[nodiscard]] double outer_distance(std::size_t a, std::size_t b) const;

    Surroundings surroundings_;
    std::vector<Point> places_;             // in the order of the journal, each once
    std::vector<std::size_t> sorted_;       // their indices by coordinates, to find them
    std::vector<std::vector<Link>> links_;  // by place
    std::vector<std::size_t> outside_;      // places outside the workspace, the first kMaxOutside
    std::vector<bool> is_outside_;          // by place: one of them
};

}  // namespace palpate
