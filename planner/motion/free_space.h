// Ways through exterior lenses, near S (planner/DESIGN.md, "Ways").
//
// What is proven free is the roadmap's segments, all outside ω, and the exterior lenses; where no bound proves any, plausible balls beside
// samples stand for lenses below. A lens is convex, so every segment
// between two of its points is free. A segment that several lenses cover together is free as well. Far ways go over hover
// points a + h n, where h is the height of the ways and n the middle of the normals that sample a may have: neighbours' hover
// points see each other.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "planner/inference/surface_model.h"

namespace palpate {

// A place in the exterior lens of a sample.
struct HoverPlace {
    Point point = Point::Zero();
    std::uint32_t home = 0;
};

class FreeSpace {
public:
    struct Way {
        std::vector<HoverPlace> stops;  // to pass in turn, without the start
        double length = 0.0;            // mm
    };

    // `hover` (mm): height of the ways above S.
    FreeSpace(const MaintainedDelaunay& state, const SurfaceModel& model, double hover) : state_(state), model_(model), hover_(hover) {}

    // Whether the lenses of these samples cover the straight way.
    [[nodiscard]] bool is_free(const Point& from, const Point& to, std::span<const std::uint32_t> lenses) const;
    // Nothing if lenses do not join the two by a way over hover points of at most that length (mm); cutting its corners makes it shorter.
    // The search is A*: it costs as much as the way is long, wherever it is, and where there is none as much as the longest would.
    [[nodiscard]] std::optional<Way> way(const HoverPlace& from, const HoverPlace& to,
                                         double at_most = std::numeric_limits<double>::infinity());

private:
    struct Label {
        double cost = 0.0;  // mm
        std::uint32_t came_from = 0;
        std::uint32_t search = 0;  // that wrote this label
        bool settled = false;
    };

    [[nodiscard]] Point hover_point(std::uint32_t sample) const;  // inside ω
    [[nodiscard]] std::optional<std::vector<std::uint32_t>> hover_way(const HoverPlace& from, const HoverPlace& to);
    bool reach(std::uint32_t sample, double cost, std::uint32_t came_from, const Point& goal);

    const MaintainedDelaunay& state_;
    const SurfaceModel& model_;
    const double hover_;
    std::vector<Label> labels_;  // by sample
    std::vector<std::pair<double, std::uint32_t>> heap_;
    std::uint32_t searches_ = 0;
    double at_most_ = 0.0;                   // mm: of this search
    std::vector<std::uint32_t> adjacent_;    // scratch
    mutable std::vector<Interval> covered_;  // scratch
};

}  // namespace palpate
