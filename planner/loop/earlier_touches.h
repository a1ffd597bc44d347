// What an earlier run touched is known before anything moves; a few of its places are touched again, to see that the object is where it was
// (planner/DESIGN.md, "Going on").
//
// May not live here: where those touches are kept (tools/earlier_session), what they make plausible (planner/plausibility).
#pragma once

#include <cstdint>
#include <functional>
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
        Vector normal = Vector::UnitZ();    // unit: of S there, as next() was told
        std::uint32_t sample = 0;
    };
    using NormalOf = std::function<Vector(std::uint32_t sample)>;
    // What to touch again next: outer places whose normals are independent, such that no sample is on the way there. Nothing once there are
    // three, or no way led to more. Throws SeedError if no way led to any, ContradictionError if what was in the way is new.
    [[nodiscard]] std::optional<Place> next(const NormalOf& normal);
    // What came of it.
    struct Found {
        std::optional<Point> met{};         // there
        std::optional<Point> on_the_way{};  // before the place where the touch was to begin
        bool is_failed = false;             // no answer
    };
    // Throws ContradictionError if S is not where it was.
    void note(const Place& place, const Found& found);

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
    std::vector<Vector> normals_;     // of those that were
    std::size_t barred_ = 0;          // places in vain since the last of those
    std::optional<Point> strange_{};  // met where the earlier run had touched nothing near
};

}  // namespace palpate
