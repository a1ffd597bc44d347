// How a machine moves, for every driver, decorator and virtual machine.
#pragma once

#include <string>

#include "devices/probe_device.h"
#include "planner/machine_time.h"

namespace palpate {

constexpr double kSecondsPerMinute = 60.0;  // many machines count feeds in mm/min

struct Feeds {
    double travel_mm_per_s = 20.0;
    double probe_mm_per_s = 5.0;
    double touch_mm_per_s = 1.0;

    [[nodiscard]] double of(Pace pace) const {
        return pace == Pace::travel ? travel_mm_per_s : pace == Pace::probe ? probe_mm_per_s : touch_mm_per_s;
    }
};

// How a tool moves and stops.
struct MotionModel {
    Feeds feeds;
    double acceleration_mm_per_s2 = 200.0;
    Seconds latency{0.002};        // from the trigger until the machine begins to slow down
    double overtravel_mm = 2.0;    // what the probe gives way after it has triggered
    double retract_mm = 0.5;       // after a contact, back along the way that the tool came
    double resolution_mm = 0.001;  // of positions that are told to and by the machine
};

// mm: from the trigger to a standstill at that feed: v·latency + v²/2a.
[[nodiscard]] inline double stopping_distance(const MotionModel& k, double feed_mm_per_s) {
    return feed_mm_per_s * k.latency.count() + feed_mm_per_s * feed_mm_per_s / (2 * k.acceleration_mm_per_s2);
}

// Whether the tool stands, at every feed, before the probe gives way no more (devices/FACTS.md, "Safety floor"): empty, or what is wrong.
[[nodiscard]] std::string stopping_problem(const MotionModel& k);
// Throws DeviceError if there is one.
void require_stopping(const MotionModel& k);

// The same for reckoning with counts of touches: every one stops, and goes back by the retract at the probing feed.
[[nodiscard]] MachineRates machine_rates(const MotionModel& k);

// Of a straight move from rest to rest: trapezoid, or triangle if it is too short to reach the feed.
[[nodiscard]] Seconds move_duration(const MotionModel& k, double length_mm, double feed_mm_per_s);

}  // namespace palpate
