// What visits to the datum showed: how far what is probed has shifted since the first one (devices/README.md, "Drift").
//
// The planner works in the part's frame: where the machine would say that things are, had nothing drifted since the first visit. It is told
// of the shift that the last visit showed. What was touched between two visits is put right afterwards, in between.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "devices/calibration/drift.h"
#include "devices/errors.h"
#include "devices/motion_model.h"
#include "devices/session/drift_datum.h"
#include "devices/session/journal.h"

namespace palpate {

// A visit to the datum that was not made to its end. A resumed session begins it again.
class DatumFault : public DeviceError {
public:
    using DeviceError::DeviceError;
};

// The datum is too far from where it was at the last visit. A resumed session touches again what was touched since.
class DriftJump : public DatumFault {
public:
    using DatumFault::DatumFault;
};

// When something was, as the journal tells it: no clock is asked.
struct JournalTime {
    std::uint64_t contacts = 0;  // touches of the part before
    Seconds time{0.0};           // that a machine takes for all moves before; drift goes on steadily in it
};

class DriftLog {
public:
    explicit DriftLog(const DriftDatum& datum) : datum_(datum) {}

    // A visit: where the touches of the datum were, as the machine said. Throws DriftJump if something moved, BadAnswer if these are not as
    // many as the datum has.
    void add(const std::vector<Point>& touched, const JournalTime& when);

    [[nodiscard]] bool has_reading() const { return !readings_.empty(); }
    // mm: what the last visit showed.
    [[nodiscard]] const Vector& shift() const { return shift_; }
    // mm: at that time; linear between visits.
    [[nodiscard]] Vector at(Seconds time) const { return drift_at(readings_, time.count()); }

    [[nodiscard]] std::size_t visits() const { return visits_; }
    [[nodiscard]] int directions() const { return directions_; }                // 0 to 3: in which a shift is seen
    [[nodiscard]] double largest_shift_mm() const { return largest_shift_; }    // since the first visit
    [[nodiscard]] double largest_change_mm() const { return largest_change_; }  // from one visit to the next

private:
    DriftDatum datum_;
    std::vector<Point> first_{};
    std::vector<DriftReading> readings_{};  // at seconds
    std::uint64_t contacts_ = 0;            // at the last of them
    Vector shift_ = Vector::Zero();
    std::size_t visits_ = 0;
    int directions_ = 0;
    double largest_shift_ = 0.0;
    double largest_change_ = 0.0;
};

// The time of a visit: the middle of its touches.
class VisitTime {
public:
    void add(Seconds time) {
        sum_ += time;
        ++count_;
    }
    [[nodiscard]] Seconds middle() const { return sum_ / std::max(count_, 1); }

private:
    Seconds sum_{0.0};
    int count_ = 0;
};

// How the shift went in a journal. Visits that were broken off, and jumps, show nothing.
struct DriftRecord {
    DriftLog log;
    std::size_t moves = 0;             // of the journal, up to and with the last visit that showed something
    std::vector<Vector> shifts{};      // mm, by move: that the target was told with
    std::vector<JournalTime> after{};  // by move
    JournalTime end{};
};
[[nodiscard]] DriftRecord read_drift(const Journal& journal, const DriftDatum& datum, const MotionModel& motion);

// The same moves in the part's frame, touches of the part put right by visits before and after them.
[[nodiscard]] Journal in_part_frame(Journal journal, const DriftRecord& drift);

}  // namespace palpate
