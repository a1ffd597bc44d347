// From touches of a table and of the part on it to what a configuration says of them. Positions are those of the ball's centre where they
// were touched, and the part's and the table's own elsewhere. The tool points straight down.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "config/editor.h"
#include "config/session_config.h"

namespace palpate {

struct TablePlane {
    Vector normal = Vector::UnitZ();  // unit, upwards
    Point point = Point::Zero();      // mm: of the table

    // mm: of the table there.
    [[nodiscard]] double height(double x, double y) const;
    // mm: of the ball's centre that touches it there.
    [[nodiscard]] double touched_height(double x, double y, double radius) const { return height(x, y) + radius / normal.z(); }
    [[nodiscard]] double tilt_degrees() const;
    // mm: between its lowest and its highest place below the box.
    [[nodiscard]] double rise_over(const Box& box) const;
};

// The places that are touched where none are given: near three sides of the limits, two in corners.
[[nodiscard]] std::array<Point, 3> default_table_places(const Box& limits);

// The table that a ball of that radius (mm) touched in three places. Throws SetupError if these are about on a line, or no table is as
// steep as the plane through them: one was on something else.
[[nodiscard]] TablePlane table_through(const std::array<Point, 3>& touched, double radius);

struct PartTouch {
    Vector approach = -Vector::UnitZ();  // unit
    Point position = Point::Zero();      // mm: the ball's centre
};

struct TableSetup {
    Box workspace;                // for the ball's centre
    std::vector<Fixture> solids;  // the table first, then those of the configuration that are no tables
    std::vector<Segment> seed_rays;
    bool is_tilted = false;  // by more than touches are off over the workspace
};

// `part`: its own box. `margin` (mm) is between what the ball touches and the workspace's faces; where the holder comes as low as the part,
// it is kept from that as well. A seed ray for each touch that is no nearer than epsilon to those before, the first one above all.
[[nodiscard]] TableSetup propose_setup(const SessionConfig& config, const TablePlane& table, const Box& part,
                                       const std::vector<PartTouch>& touches, double radius, double margin);

// What of the configuration has to change for that.
[[nodiscard]] std::vector<KeyEdit> edits_of(const TableSetup& setup, const SessionConfig& config);

}  // namespace palpate
