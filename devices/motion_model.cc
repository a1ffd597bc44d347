#include "devices/motion_model.h"

#include <fmt/format.h>

#include <cmath>

#include "devices/errors.h"

namespace palpate {

std::string stopping_problem(const MotionModel& k) {
    for (const Pace pace : {Pace::travel, Pace::probe, Pace::touch}) {
        const double feed = k.feeds.of(pace);
        const double distance = stopping_distance(k, feed);
        if (distance < k.overtravel_mm) continue;
        return fmt::format("at {:g} mm/s the machine needs {:g} mm to stop, but the probe gives way by {:g} mm", feed, distance,
                           k.overtravel_mm);
    }
    return "";
}

void require_stopping(const MotionModel& k) {
    if (const std::string problem = stopping_problem(k); !problem.empty()) {
        throw DeviceError(fmt::format("{}; lower that feed, or give the true acceleration, latency and overtravel", problem));
    }
}

MachineRates machine_rates(const MotionModel& k) {
    const double feed = k.feeds.probe_mm_per_s;
    const double run_on = stopping_distance(k, feed);
    // Starting and stopping take v/2a each besides the way at that feed.
    const Seconds stopping(run_on / feed + feed / k.acceleration_mm_per_s2);
    return {k.feeds.travel_mm_per_s, feed, stopping + move_duration(k, run_on + k.retract_mm, feed)};
}

Seconds move_duration(const MotionModel& k, double length_mm, double feed_mm_per_s) {
    const double ramps = feed_mm_per_s * feed_mm_per_s / k.acceleration_mm_per_s2;  // mm: speeding up and slowing down
    if (length_mm >= ramps) return Seconds(length_mm / feed_mm_per_s + feed_mm_per_s / k.acceleration_mm_per_s2);
    return Seconds(2 * std::sqrt(length_mm / k.acceleration_mm_per_s2));
}

}  // namespace palpate
