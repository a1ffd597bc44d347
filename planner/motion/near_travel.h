// Brings the tool to places near S, over space that is proven free or taken to be: guarded, so that a wrong guess is a touch.
//
// May not live here: what to touch (advancing_front.h), what a touch means (surface_growth.h).
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "planner/motion/free_space.h"
#include "planner/motion/probe_head.h"
#include "planner/motion/probed_space.h"

namespace palpate {

class NearTravel {
public:
    // `epsilon` (mm): how far samples are apart. `retract` (mm): the least lift off a touch. All references must outlive it.
    NearTravel(ProbedSpace& space, ProbeHead& head, const SurfaceModel& model, double epsilon, double retract);

    // Each of these answers if S is met on the way, or a touch there failed; the tool is there then. `on_free_way`: a lens says that S is
    // not there.
    using Met = ProbeHead::Answer;

    // To a place in a sample's lens.
    std::optional<Met> go_to(const HoverPlace& goal);
    // Straight, through whatever there is. `expects`: S is known to lie before the goal.
    std::optional<Met> probe(const Point& goal, bool expects = false);
    // Towards a node of the roadmap near those samples, as far as that is shorter than the roadmap.
    // `is_cramped`: straight ways are mostly barred there, so that one try is enough.
    std::optional<Met> approach(NodeId goal, const std::array<std::uint32_t, 3>& samples, bool is_cramped);

    // Lenses are not what they were.
    void forget_all() { doors_.clear(); }

private:
    // From a touch back on the way to it, into a lens: no way may lead through a place on S.
    void lift();
    // The tool's place, if it is in some lens.
    [[nodiscard]] std::optional<HoverPlace> place();
    [[nodiscard]] std::optional<std::uint32_t> home_of(const Point& p);
    // A place in the sample's lens, on the way of the probe that touched it; none if that way is too flat.
    [[nodiscard]] NodeId door(std::uint32_t sample);
    // Straight to a place, or over what is in the way, if earlier hops did not end there. Not done if too many did not.
    struct Hop {
        bool done = false;
        std::optional<Met> met;
    };
    Hop hop(const Point& goal);
    // Out of ω along S's normal here, and in along that at the goal.
    Hop go_round(const Point& goal);
    // S's normal at the nearest sample, or what is known of it.
    [[nodiscard]] Vector up_at(const Point& p);
    std::optional<Met> follow(const FreeSpace::Way& way);

    MaintainedDelaunay& state_;
    Roadmap& roadmap_;
    ProbeHead& head_;
    const SurfaceModel& model_;
    FreeSpace free_space_;
    const double epsilon_;
    const double lift_;                              // mm
    std::uint32_t near_ = 0;                         // a sample near the tool
    NodeId lifted_ = kNoNode;                        // where the tool lifted to from its last contact
    NodeId retreat_ = kNoNode;                       // a place before that which is not beside S
    std::vector<NodeId> doors_;                      // by sample, as far as they were needed
    std::map<std::array<double, 3>, int> contacts_;  // on hops to a place
};

}  // namespace palpate
