#include "planner/motion/probe_watch.h"

#include <algorithm>

namespace palpate {
namespace {

// Of ε: nodes that split a segment lie on it up to rounding, which is far less; no two ways that differ are that near.
constexpr double kOnSegment = 1e-6;

}  // namespace

void ProbeWatch::note_contact() {
    has_contact_ = true;
    note_proof();
}

void ProbeWatch::note_proof() {
    clears_ = 0;
    way_ = 0;
    unconfirmed_.clear();
}

void ProbeWatch::note_clear(const Segment& way) {
    ++clears_;
    way_ += (way.target - way.source).norm();
    unconfirmed_.push_back(way);
}

bool ProbeWatch::is_due() const {
    // The rays that look for the object are long: before the first contact they are counted, not measured.
    return clears_ >= kMaxClears || (has_contact_ && way_ >= kMaxWay * epsilon_);
}

bool ProbeWatch::is_unconfirmed(const Segment& way) const {
    if (!has_contact_ || misses_touches_) return true;
    const double tolerance = kOnSegment * epsilon_;
    return std::any_of(unconfirmed_.begin(), unconfirmed_.end(), [&](const Segment& clear) {
        return distance_to(clear, way.source) <= tolerance && distance_to(clear, way.target) <= tolerance;
    });
}

}  // namespace palpate
