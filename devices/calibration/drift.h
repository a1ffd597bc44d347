// How a machine drifts while it probes, by datum touches that are made again now and then.
#pragma once

#include <stdexcept>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

// Readings that no drift can be told from. The message says which, and what to do.
class DriftError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

// A known place that was touched again.
struct DatumOffset {
    Vector normal = Vector::UnitZ();  // unit, outwards: a shift along the surface does not show
    double offset_mm = 0.0;           // along it: now less then
};

// mm: the shift that fits to these offsets best (least squares). Throws DriftError if their normals leave a direction open: three that are
// independent are needed, or a sphere's centre in place of all this.
[[nodiscard]] Vector shift_of(const std::vector<DatumOffset>& offsets);

// What touches with these normals show of a shift.
struct SeenShift {
    Vector shift = Vector::Zero();  // mm: where no touch shows it, 0
    int directions = 0;             // independent ones that the touches show, 0 to 3
};

// As shift_of, but what touches leave open is taken to be 0. Throws DriftError on numbers that are not finite.
[[nodiscard]] SeenShift seen_shift_of(const std::vector<DatumOffset>& offsets);

struct DriftReading {
    double at = 0.0;                // when: touches or seconds of the journal, one of them for all
    Vector shift = Vector::Zero();  // mm: of what is probed, since the first reading
};

// Throws DriftError if readings are not in order of time, not finite, or two that follow each other are more than `most_jump_mm` (> 0)
// apart: that is no drift, something moved in between.
void require_steady(const std::vector<DriftReading>& readings, double most_jump_mm);

// mm: linear between readings; before the first and after the last it is theirs; without readings 0.
// REQUIRES: readings in order of time (require_steady()).
[[nodiscard]] Vector drift_at(const std::vector<DriftReading>& readings, double at);

// Where `touched` would have been touched at the first reading.
[[nodiscard]] inline Point without_drift(const Point& touched, const std::vector<DriftReading>& readings, double at) {
    return touched - drift_at(readings, at);
}

}  // namespace palpate
