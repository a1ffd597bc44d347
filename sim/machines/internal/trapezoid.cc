#include "sim/machines/internal/trapezoid.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace palpate {

Trapezoid::Trapezoid(double length, double feed, double acceleration, double speed) : acceleration_(acceleration) {
    assert(length >= 0.0 && feed > 0.0 && acceleration > 0.0 && speed >= 0.0);
    const double top = speed > feed ? feed : std::min(feed, std::sqrt(length * acceleration + speed * speed / 2));
    const double change = std::abs(top - speed) / acceleration;
    const double ramp = top / acceleration;
    append({change, speed, speed > feed ? -acceleration : acceleration});
    append({std::max(0.0, (length - (top + speed) / 2 * change - top / 2 * ramp) / feed), top, 0.0});
    append({ramp, top, -acceleration});
}

void Trapezoid::append(const Phase& phase) {
    assert(count_ < kMostPhases);
    if (phase.time > 0.0) phases_[count_++] = phase;
}

double Trapezoid::length() const { return distance(duration()); }

Seconds Trapezoid::duration() const {
    double time = 0.0;
    for (std::size_t i = 0; i < count_; ++i) time += phases_[i].time;
    return Seconds(time);
}

double Trapezoid::distance(Seconds time) const {
    double left = std::max(0.0, time.count());
    double distance = 0.0;
    for (std::size_t i = 0; i < count_; ++i) {
        distance += phases_[i].distance_after(std::min(left, phases_[i].time));
        if (left <= phases_[i].time) break;
        left -= phases_[i].time;
    }
    return distance;
}

double Trapezoid::speed(Seconds time) const {
    double left = std::max(0.0, time.count());
    for (std::size_t i = 0; i < count_; ++i) {
        if (left <= phases_[i].time) return std::max(0.0, phases_[i].speed + phases_[i].acceleration * left);
        left -= phases_[i].time;
    }
    return 0.0;
}

std::optional<Seconds> Trapezoid::time_at(double distance) const {
    if (distance <= 0.0) return Seconds(0.0);
    double left = distance;
    double time = 0.0;
    for (std::size_t i = 0; i < count_; ++i) {
        const Phase& phase = phases_[i];
        const double whole = phase.distance_after(phase.time);
        if (left <= whole) {
            // The smaller root of speed·t + acceleration·t²/2 = left, without cancellation.
            const double root = std::sqrt(std::max(0.0, phase.speed * phase.speed + 2 * phase.acceleration * left));
            return Seconds(time + std::min(phase.time, 2 * left / (phase.speed + root)));
        }
        left -= whole;
        time += phase.time;
    }
    return std::nullopt;
}

Trapezoid Trapezoid::stopped_from(Seconds time) const {
    Trapezoid result = *this;
    result.count_ = 0;
    double left = std::max(0.0, time.count());
    for (std::size_t i = 0; i < count_; ++i) {
        const Phase& phase = phases_[i];
        if (i + 1 == count_) {  // it slows down already
            result.append(phase);
            continue;
        }
        if (left >= phase.time) {
            result.append(phase);
            left -= phase.time;
            continue;
        }
        result.append({left, phase.speed, phase.acceleration});
        const double speed = phase.speed + phase.acceleration * left;
        result.append({speed / acceleration_, speed, -acceleration_});
        break;
    }
    return result;
}

}  // namespace palpate
