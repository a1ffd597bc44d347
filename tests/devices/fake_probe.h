// A probe in front of a simple solid that answers exactly, unless a script gives it noise, false triggers and faults.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "devices/errors.h"
#include "devices/probe_device.h"

namespace palpate {

// mm from `from` towards `to` until the solid is met; nothing if it is not met between them.
using FirstHit = std::function<std::optional<double>(const Point& from, const Point& to)>;

// The solid { x : x·normal <= offset }; `normal` of unit length.
inline FirstHit half_space(const Vector& normal, double offset) {
    return [=](const Point& from, const Point& to) -> std::optional<double> {
        const double before = from.dot(normal) - offset;
        const double after = to.dot(normal) - offset;
        if (after > 0 || after >= before) return std::nullopt;
        return before / (before - after) * (to - from).norm();
    };
}

inline FirstHit ball(const Point& center, double radius) {
    return [=](const Point& from, const Point& to) -> std::optional<double> {
        const double length = (to - from).norm();
        const Vector way = (to - from) / length;
        const double nearest = (center - from).dot(way);
        const double beside = (center - from).squaredNorm() - nearest * nearest;
        if (beside >= radius * radius) return std::nullopt;
        const double t = nearest - std::sqrt(radius * radius - beside);
        return t >= 0 && t <= length ? std::optional(t) : std::nullopt;
    };
}

inline FirstHit nothing() {
    return [](const Point&, const Point&) { return std::nullopt; };
}

class FakeProbe final : public ProbeDevice {
public:
    struct Move {
        Point from;
        Point target;
        Pace pace;
        MoveResult result;
        bool is_false = false;  // ended by a trigger where nothing is
    };

    // Goes back by `retract` (mm) after a touch, but not farther than where the move began.
    FakeProbe(FirstHit solid, const Point& start, double retract) : solid_(std::move(solid)), retract_(retract), position_(start) {}

    [[nodiscard]] Point position() const override { return position_; }
    [[nodiscard]] MoveResult guarded_move(const Point& target, Pace pace) override {
        if (fault && fault()) throw ConnectionLost("cable pulled");
        const double length = (target - position_).norm();
        Move move{position_, target, pace, {MoveResult::Outcome::reached, target}, false};
        std::optional<double> touched = length > 0 ? solid_(position_, target) : std::nullopt;
        if (touched && noise) touched = std::max(0.0, *touched + noise(pace));
        if (touched && *touched > length) touched.reset();
        if (const auto trigger = false_trigger && length > 0 ? false_trigger(move) : std::nullopt;
            trigger && *trigger < touched.value_or(length)) {
            touched = trigger;
            move.is_false = true;
        }
        position_ = target;
        if (touched) {
            const Vector way = (target - move.from) / length;
            move.result = {MoveResult::Outcome::contact, move.from + *touched * way};
            position_ = move.from + std::max(0.0, *touched - retract_) * way;
        }
        if (events) move.result.events = events();
        log.push_back(move);
        return move.result;
    }
    void stop() override { ++stops; }

    std::function<double(Pace)> noise;                                     // mm along the way, added to where S is touched
    std::function<std::optional<double>(const Move& move)> false_trigger;  // mm along the way
    std::function<std::vector<DeviceEvent>()> events;
    std::function<bool()> fault;
    std::vector<Move> log;
    int stops = 0;

private:
    FirstHit solid_;
    double retract_;
    Point position_;
};

}  // namespace palpate
