#include "devices/device_oracle.h"

#include "devices/errors.h"

namespace palpate {

std::string UnexpectedContact::message(const Point& where, const std::string& during) {
    return "touched something at (" + std::to_string(where.x()) + ", " + std::to_string(where.y()) + ", " + std::to_string(where.z()) +
           ") during " + during + ", where space was proven free: the part moved, the probe triggered falsely, or a bound is false";
}

void DeviceOracle::travel(std::span<const Point> path) {
    for (const Point& target : path) {
        if (const MoveResult result = device_.guarded_move(target, Pace::travel); result.outcome == MoveResult::Outcome::contact) {
            throw UnexpectedContact(result.position, "travel");
        }
    }
}

ProbeAnswer DeviceOracle::probe(const Point& target) {
    const MoveResult result = device_.guarded_move(target, Pace::probe);
    return {result.outcome == MoveResult::Outcome::contact ? ProbeAnswer::Outcome::contact : ProbeAnswer::Outcome::clear, result.position};
}

}  // namespace palpate
