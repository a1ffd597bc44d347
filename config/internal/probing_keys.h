// `workspace:` and `probing:` of a configuration.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "config/internal/box_keys.h"
#include "config/internal/kinds.h"
#include "config/internal/tool_keys.h"
#include "config/session_config.h"
#include "config/strategy_names.h"
#include "planner/area.h"
#include "planner/options.h"

namespace palpate::yaml {

inline constexpr std::array<std::string_view, 1> kWorkspaceWords{"auto"};
inline constexpr Bounds kFloorBounds{0.0, 1.0, false};
inline constexpr Bounds kShareBounds{0.0, 1.0, true};
inline constexpr Bounds kMinAngleBounds{0.0, 30.0, true};  // above, refinement need not end (thesis 5.3)
inline constexpr OrNull kLengthOrNull{Number{kLength}};

template <class Archive>
void describe(Archive& keys, Ball& ball) {
    keys.value({"center", "centre of the ball", Need::required, kMillimetres}, ball.center, Triple{Number{kCoordinate}});
    keys.value({"radius", "radius of the ball", Need::required, kMillimetres}, ball.radius, Number{kLength});
}

template <class Archive>
void describe(Archive& keys, Box& box) {
    describe_box(keys, "corner with the smallest coordinates", "corner with the greatest coordinates; each greater than in `min`", box);
}

template <class Archive>
void describe(Archive& keys, WorkspaceSpec& workspace, Fixtures& fixtures) {
    alternative<Ball>(keys, {"ball", "a ball"}, workspace);
    alternative<Box>(keys, {"box", "a box along the axes"}, workspace);
    if (keys.wants(are_given(fixtures))) describe(keys, fixtures);
    keys.require_one_alternative();
    const auto* const box = std::get_if<Box>(&workspace);
    keys.require(box != nullptr || fixtures.solids.empty(), "fixtures", "stand beside a ball; allowed: with workspace.box only");
    keys.require(box == nullptr || std::ranges::none_of(fixtures.solids, [&](const Fixture& f) { return covers(f, *box); }), "fixtures",
                 "one of them covers the whole workspace; allowed: those that leave some of workspace.box free");
}

template <class Archive>
void describe(Archive& keys, Strategy& strategy) {
    keys.value({"refine", "which touches become samples: the worst once every reachable edge is probed, or every bad one at once"},
               strategy.refine, Word{strategy_words<Strategy::Refine>()});
    keys.value({"explore", "which edges are probed: all that can be reached, or what closes the surface"}, strategy.explore,
               Word{strategy_words<Strategy::Explore>()});
    keys.value({"infer",
                "what is concluded without a probe: nothing; what `probing.reach` proves; what the samples around make plausible; or "
                "`reach` where one is given, else `adaptive`"},
               strategy.infer, Word{strategy_words<Strategy::Infer>()});
    keys.value(
        {"travel", "along which ways the probe moves: along Voronoi edges, or near the surface through all space that is proven free"},
        strategy.travel, Word{strategy_words<Strategy::Travel>()});
}

template <class Archive>
void describe(Archive& keys, Segment& ray) {
    keys.value({"from", "where the ray starts", Need::required, kMillimetres}, ray.source, Triple{Number{kCoordinate}});
    keys.value({"to", "where it aims and ends; differs from `from`", Need::required, kMillimetres}, ray.target,
               Triple{Number{kCoordinate}});
    keys.require(ray.source != ray.target, "to", "is the same point as from; allowed: another point (mm)");
}

template <class Archive>
void describe(Archive& keys, RegionOfInterest& region) {
    describe_corners(keys, "lowest corner of a box", "its highest corner; a point if it is the same", region.box);
    keys.value({"size", "upper bound on ball radii in the box", Need::required, kMillimetres}, region.size, Number{kLength});
    keys.value({"slope", "by how much that grows with the distance from the box, up to epsilon"}, region.slope, Number{kShareBounds});
    keys.require((region.box.min.array() <= region.box.max.array()).all(), "max",
                 "lies below min; allowed: no coordinate below that of min (mm)");
}

template <class Archive>
void describe(Archive& keys, Sizing& sizing) {
    list(keys, {"regions", "boxes and points of interest"}, {}, sizing.regions);
    keys.value({"radii_of_curvature", "upper bound on ball radii, in radii of curvature as the facets around show them; 0: none"},
               sizing.radii_of_curvature, Number{kNotNegative});
    keys.value({"smallest", "curvature refines no smaller balls; null: twice the refinement floor", Need::optional, kMillimetres},
               sizing.smallest, kLengthOrNull);
}

template <class Archive>
void describe(Archive& keys, Budget& budget) {
    keys.value({"probes", "the run ends after so many, incomplete; null: any"}, budget.probes, OrNull{Whole{}});
    keys.value({"displacement", "the same for the way of the probe", Need::optional, kMillimetres}, budget.displacement,
               OrNull{Number{kPositive}});
    keys.value({"machine_time", "the same for the machine's time, reckoned with machine.feeds", Need::optional, kSeconds},
               budget.machine_time, OrNull{Number{kPositive}});
}

template <class Archive>
void describe(Archive& keys, Prism& prism) {
    keys.value({"corners", "x and y of its corners, in order, either way around; it need not be convex", Need::required, kMillimetres},
               prism.corners, FlatPoints{Number{kCoordinate}});
    keys.value({"z", "from this height to that one", Need::optional, kMillimetres}, prism.z, Row<2, Number>{Number{kCoordinate}});
    const std::string problem = problem_of(prism.corners);
    keys.require(problem.empty(), "corners", problem);
    keys.require(prism.z[0] < prism.z[1], "z", "does not rise; allowed: [low, high], high greater than low (mm)");
}

template <class Archive>
void describe(Archive& keys, Area& area) {
    alternative<Box>(keys, {"box", "a box along the axes"}, area);
    alternative<Prism>(keys, {"polygon", "all that lies above and below a polygon as seen along z"}, area);
    keys.require_one_alternative();
}

template <class Archive>
void describe(Archive& keys, Options& options) {
    keys.value({"epsilon", "upper bound on the radius of every surface Delaunay ball of the result", Need::required, kMillimetres},
               options.epsilon, Number{kLength});
    keys.value({"reach", "lower bound on the reach of the surface that you vouch for; null: none given", Need::optional, kMillimetres},
               options.reach, kLengthOrNull);
    const auto named = keys.word_or_mapping(
        {"strategy",
         "how the next probe is chosen; `thesis` is exhaustive, exhaustive, none, voronoi; `adaptive` is the default with that `infer`",
         Need::optional, "", "default"},
        strategy_names(), std::nullopt, [&](Archive& inner) { describe(inner, options.strategy); });
    if (named) options.strategy = named_strategy(*named);
    keys.value({"standoff", "how far above the surface a probe starts where that is proven free; null: half of epsilon", Need::optional,
                kMillimetres},
               options.standoff, kLengthOrNull);
    if (keys.wants(options.tolerance || options.spacing_min)) {
        keys.value(
            {"tolerance",
             "99 % of a curved surface through the touches, surface.ply, are to be that near to the object's, as touches foretell: samples "
             "are as near to each other as that takes, `epsilon` is the largest spacing; null: none is asked for",
             Need::optional, kMillimetres},
            options.tolerance, kLengthOrNull);
        keys.value({"spacing_min", "with a tolerance samples come no nearer to each other; null: the tolerance, or 20 touch errors",
                    Need::optional, kMillimetres},
                   options.spacing_min, kLengthOrNull);
        mapping(keys, {"tolerance_box", "the tolerance is asked for in this box alone", Need::optional, "", "everywhere"},
                options.tolerance_box);
    }
    keys.value({"trust",
                "how likely a plausible facet may be wrong: one that is 8 times as likely wrong is touched, so that far fewer are on the "
                "whole; 0: whatever is not proven is touched"},
               options.trust, Number{kShareBounds});
    keys.value({"audit",
                "share of the inferred facets that are touched anyway: 60 at least, but no more than 5 % of the samples, and at most 300; "
                "0: none"},
               options.audit, Number{kShareBounds});
    list(keys, {"seed_rays", "probed first, one per component at least; none: rays from the workspace towards its centre"}, {},
         options.seed_rays);
    keys.value(
        {"refinement_floor",
         "where the mesh is not manifold, or a wall is thinner than samples show, balls are refined down to this fraction of epsilon; "
         "walls thinner than 1.7 times that stay out of the mesh and are named"},
        options.refinement_floor, Number{kFloorBounds});
    mapping(keys, {"sizing", "where smaller facets are wanted than epsilon asks for", Need::optional, "", "none", Layout::block},
            options.sizing);
    keys.value({"min_angle", "triangles with a smaller angle are refined, away from seeds", Need::optional, kDegrees}, options.min_angle,
               Angle{kMinAngleBounds});
    mapping(keys, {"budget", "what the run may use up", Need::optional, "", "none"}, options.budget);
}

}  // namespace palpate::yaml
