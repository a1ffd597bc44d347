#include "devices/calibration/probe_qualification.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "devices/errors.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

constexpr std::size_t kMostDirections = 50;
// Five touches leave the lobes' range of its centre open; a wrong diameter is found out before.
constexpr double kFound_mm = 0.3;

class SphereProbe {
public:
    SphereProbe(ProbeDevice& device, const ReferenceSphere& sphere, const ToolShape& tool, const TouchMargins& margins)
        : device_(device), sphere_(sphere), farthest_(farthest_touch(sphere, tool, margins)) {}

    // Along a way that is to be free.
    void follow(const std::vector<Point>& way) {
        for (const Point& target : way) go(target, "the way around the sphere");
    }
    SphereTouch touch(const PlannedTouch& planned) {
        const Point start = planned.way.back();
        for (int again = 0; again <= kMaxFalseTriggers; ++again) {
            const MoveResult result = move_past_sparks(device_, planned.target, Pace::probe);
            if (result.outcome == MoveResult::Outcome::reached) refuse_miss(planned, start);
            if (result.outcome == MoveResult::Outcome::contact && (result.position - sphere_.center).norm() > farthest_) {
                throw UnexpectedContact(result.position, "the way to the sphere");
            }
            go(start, "the way back from the sphere");
            // A trigger that was over when the tool stood is a spark, or a graze, which the sphere has none of.
            if (result.outcome == MoveResult::Outcome::contact && result.held) return {result.position, -planned.normal};
        }
        throw DeviceError(fmt::format("the sphere could not be touched at {}: the probe triggers and lets go; look at its wiring",
                                      point_text(planned.target)));
    }

private:
    void go(const Point& target, const char* during) {
        const MoveResult result = move_past_sparks(device_, target, Pace::probe);
        if (result.outcome != MoveResult::Outcome::reached) throw UnexpectedContact(result.position, during);
    }
    // A probe that missed the sphere may be dead and pressed on it.
    [[noreturn]] void refuse_miss(const PlannedTouch& planned, const Point& start) {
        go(start, "the way back from where the sphere should be");
        throw DeviceError(
            fmt::format("nothing was touched on the way to {}, where the sphere has to be: the sphere stands elsewhere, or the probe "
                        "is dead. Look at both, press the probe by hand, and begin again",
                        point_text(planned.target)));
    }

    ProbeDevice& device_;
    const ReferenceSphere sphere_;
    const double farthest_;
};

void require_sense(const QualificationSettings& settings) {
    if (settings.directions < kIsoTouches || settings.directions > kMostDirections) {
        throw QualificationError(fmt::format("{} directions: {} to {} can be touched", settings.directions, kIsoTouches, kMostDirections));
    }
    if (settings.repeats < 2) throw QualificationError("a place has to be touched twice at least to see how well the probe repeats");
    if (!(settings.resolution_mm > 0)) throw QualificationError("the machine's resolution has to be positive");
    if (!(settings.margins.clearance_mm >= settings.margins.center_error_mm)) {
        throw QualificationError("the clearance around the sphere has to be at least the error of its centre");
    }
    const double pressed = 2 * settings.margins.center_error_mm + kMostPretravel_mm;
    if (!(pressed <= settings.overtravel_mm)) {
        throw QualificationError(
            fmt::format("a dead probe would be pressed {:.2f} mm into the sphere, its overtravel is {:.2f} mm: say more exactly "
                        "where the sphere is",
                        pressed, settings.overtravel_mm));
    }
}

// The sphere where five touches find it.
ReferenceSphere found_sphere(ProbeDevice& device, const ReferenceSphere& sphere, const ToolShape& tool, const TouchMargins& margins) {
    const TouchPlan plan = plan_touches(sphere, tool, margins, device.position(), centering_directions(tool.axis));
    SphereProbe probe(device, sphere, tool, margins);
    std::vector<SphereTouch> touches;
    for (const PlannedTouch& planned : plan.touches) {
        probe.follow(planned.way);
        touches.push_back(probe.touch(planned));
    }
    probe.follow(plan.leave);
    const Ball found = fit_sphere(touches, sphere.center);
    const double expected = touched_distance(sphere, tool);
    if (std::abs(found.radius - expected) > kMostPretravel_mm) {
        throw QualificationError(
            fmt::format("sphere and ball are together {:.2f} mm thick, not {:.2f} as their diameters say: give those that they have",
                        2 * found.radius, 2 * expected));
    }
    const double off = (found.center - sphere.center).norm();
    if (off > margins.center_error_mm) {
        throw QualificationError(
            fmt::format("the sphere's centre is {:.2f} mm from where it was said to be, farther than {:.2f} mm: it is at {}", off,
                        margins.center_error_mm, point_text(found.center)));
    }
    return {found.center, sphere.diameter};
}

}  // namespace

SphereTouches touch_sphere(ProbeDevice& device, const ReferenceSphere& sphere, const ToolShape& tool,
                           const QualificationSettings& settings) {
    require_sense(settings);
    const ReferenceSphere found = found_sphere(device, sphere, tool, settings.margins);
    const std::vector<Vector> directions = qualification_directions(tool.axis, settings.directions);
    const std::vector<std::size_t> repeated = repeated_directions();
    const TouchMargins margins{std::min(settings.margins.center_error_mm, kFound_mm), settings.margins.clearance_mm};
    const TouchPlan plan = plan_touches(found, tool, margins, device.position(), directions);
    SphereProbe probe(device, found, tool, margins);
    SphereTouches touches;
    for (std::size_t k = 0; k < plan.touches.size(); ++k) {
        probe.follow(plan.touches[k].way);
        touches.touches.push_back(probe.touch(plan.touches[k]));
        if (std::ranges::find(repeated, k) == repeated.end()) continue;
        std::vector<SphereTouch>& group = touches.repeats.emplace_back(1, touches.touches.back());
        while (group.size() < settings.repeats) group.push_back(probe.touch(plan.touches[k]));
    }
    probe.follow(plan.leave);
    return touches;
}

Qualification qualify_probe(ProbeDevice& device, const ReferenceSphere& sphere, const ToolShape& tool,
                            const QualificationSettings& settings) {
    const SphereTouches touches = touch_sphere(device, sphere, tool, settings);
    const ReferenceSphere found{fit_sphere(touches.touches, sphere.center).center, sphere.diameter};
    return qualify(touches, found, tool.axis, settings.resolution_mm);
}

}  // namespace palpate
