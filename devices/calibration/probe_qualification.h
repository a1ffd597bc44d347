// Drives a probe around a calibrated sphere, and says what it is worth.
#pragma once

#include "devices/calibration/touch_plan.h"
#include "devices/probe_device.h"

namespace palpate {

struct QualificationSettings {
    TouchMargins margins;
    double overtravel_mm = 2.0;    // > 0: what the probe gives way after it has triggered (MotionModel)
    double resolution_mm = 0.001;  // > 0: of the machine's positions (MotionModel)
    std::size_t directions = 50;   // 25 to 50: touched once for the map
    std::size_t repeats = 5;       // >= 2: touches at each of repeated_directions() for the repeatability
};

// Touches the sphere: five times to find its centre, then along its normals. The tool has to stand above the equator (plan_touches) with
// nothing but the sphere in reach of it and its stem below; it ends above the pole. Every move is guarded and as slow as a probe, as
// nothing has proven the space around the sphere free; so the touches are made as later ones are, at Pace::probe through the same
// decorators. Uncertainties that a dead probe would be pressed by, 2 * center_error + kMostPretravel_mm, are within the overtravel.
//
// Throws QualificationError (before anything moves, if settings make no sense; after the five, if the sphere or the ball is of
// another diameter), UnexpectedContact for a contact where none should be, after which nothing moves any more; DeviceError for a contact
// that is missing, after the way back, or that cannot be measured; and what the device throws.
[[nodiscard]] SphereTouches touch_sphere(ProbeDevice& device, const ReferenceSphere& sphere, const ToolShape& tool,
                                         const QualificationSettings& settings = {});

// The same, and what comes of it (qualify()).
[[nodiscard]] Qualification qualify_probe(ProbeDevice& device, const ReferenceSphere& sphere, const ToolShape& tool,
                                          const QualificationSettings& settings = {});

}  // namespace palpate
