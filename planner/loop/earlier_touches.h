// What an earlier run touched is known before anything moves; a few of its places are touched again, to see that the object is where it was
// (planner/DESIGN.md, "Going on").
//
// May not live here: where those touches are kept (tools/earlier_session), what they make plausible (planner/plausibility).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "planner/certificate.h"
#include "planner/criteria.h"
#include "planner/motion/probe_head.h"
#include "planner/motion/probed_space.h"
#include "planner/options.h"

namespace palpate {

class EarlierTouches {
public:
    // Initialises the triangulation. The earlier run's samples are samples, and so are touches that are as far from them as samples are.
    // What lies on known solids is left out: this run looks that up itself. Throws SeedError if samples do not span a volume. Linear
    // memory.
    EarlierTouches(const Options& options, double touch_error, const Criteria& criteria, ProbedSpace& space, ProbeHead& head);

    // A touch that is no sample.
    struct Other {
        Point position = Point::Zero();
        Point from = Point::Zero();
    };
    [[nodiscard]] const std::vector<Other>& others() const { return others_; }

    struct Place {
        Point at = Point::Zero();
        Vector outwards = Vector::UnitZ();  // unit: where the probe that touched it came from
        std::uint32_t sample = 0;
    };
    // What to touch again next: places seen from as different sides as there are, one for each direction in which the object may have
    // moved, and such that no sample is on the way there. Nothing once there are three. Throws SeedError if no way led to enough of them.
    [[nodiscard]] std::optional<Place> next();
    // Something was met there, or no way led there. Throws ContradictionError if that is not where it was.
    void note(const Place& place, const std::optional<Point>& met);

    [[nodiscard]] const EarlierEvidence& evidence() const { return evidence_; }

private:
    // Of facets whose dual edges it lies on, from the side that it was touched from.
    void learn_crossings(const Other& touch, std::uint32_t number, MaintainedDelaunay& state) const;
    [[nodiscard]] bool is_seen(const Place& place) const;

    const MaintainedDelaunay& state_;
    const double epsilon_;
    const double same_place_;  // mm
    EarlierEvidence evidence_;
    std::vector<Place> places_;  // those that may still be touched again
    std::vector<Other> others_;
    std::vector<Vector> directions_;  // of those that were
    std::size_t barred_ = 0;
};

}  // namespace palpate
