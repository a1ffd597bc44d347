// `simulation:` of a configuration.
#pragma once

#include <string_view>

#include "config/internal/kinds.h"
#include "sim/probe/probe_errors.h"

namespace palpate::yaml {

inline constexpr Bounds kErrorShare{0.0, 1.0, true};
inline constexpr std::string_view kCompliance = "mm/N";

// Drift alone.
template <class Archive>
void describe_drift(Archive& keys, ProbeErrors& errors) {
    keys.value({"per_hour", "in an hour", Need::optional, kMillimetres}, errors.drift_mm_per_hour, Triple{Number{kCoordinate}});
    keys.value({"per_1000_touches", "in a thousand touches", Need::optional, kMillimetres}, errors.drift_mm_per_1000_touches,
               Triple{Number{kCoordinate}});
    keys.value({"swing", "to and fro besides, by that on each side", Need::optional, kMillimetres}, errors.swing_mm,
               Triple{Number{kCoordinate}});
    keys.value({"period", "of that", Need::optional, kSeconds}, errors.swing_period, Number{kPositive});
}

template <class Archive>
void describe(Archive& keys, ProbeErrors& errors) {
    keys.value({"sigma", "standard deviation of repeated touches along their way", Need::optional, kMillimetres}, errors.sigma_mm,
               Number{kLengthOrZero});
    keys.value({"latency", "triggers are read so late: positions are farther along the way by what the tool goes meanwhile", Need::optional,
                kSeconds},
               errors.latency, Number{kNotNegative});
    keys.value(
        {"lobes",
         "range of pre-travel across the stylus, which is that to twice that, in three lobes that begin at x, and half of it along the "
         "stylus",
         Need::optional, kMillimetres},
        errors.lobes_mm, Number{kLengthOrZero});
    keys.value(
        {"harmonics", "what pre-travel is less by: spherical harmonics as a calibration's `lobing_mm`", Need::optional, kMillimetres},
        errors.harmonics_mm, Row<LobingMap::kCoefficients, Number>{Number{kCoordinate}});
    keys.value({"trigger_force", "presses the ball when the probe triggers, and bends the stylus", Need::optional, "N"},
               errors.trigger_force_n, Number{kNotNegative});
    keys.value({"compliance_across", "of the stylus, against a force across it", Need::optional, kCompliance},
               errors.compliance_across_mm_per_n, Number{kLengthOrZero});
    keys.value({"compliance_along", "the same against one along it", Need::optional, kCompliance}, errors.compliance_along_mm_per_n,
               Number{kLengthOrZero});
    keys.value({"backlash", "play of each axis: on its way down it is so much higher than the machine says", Need::optional, kMillimetres},
               errors.backlash_mm, Triple{Number{kLengthOrZero}});
    keys.mapping({"drift", "where the tool is, less what the machine says", Need::optional, "", "none"}, true,
                 [&](Archive& inner) { describe_drift(inner, errors); });
    keys.value({"false_triggers", "share of the moves towards a touch that trigger where nothing is"}, errors.false_triggers,
               Number{kErrorShare});
    keys.value({"misses", "share of the touches that are not noticed"}, errors.misses, Number{kErrorShare});
    keys.value({"bounces", "share of the touches around which the probe opens and closes again; of virtual machines"}, errors.bounces,
               Number{kErrorShare});
}

}  // namespace palpate::yaml
