#include "planner/baselines/internal/meter.h"

#include "planner/random.h"

namespace palpate {

void Meter::travel(const std::vector<Point>& path) {
    oracle_.travel(path, Ground::proven);
    cost_.travel += path_length(at_, path);
    at_ = path.back();
}

std::optional<Point> Meter::probe(const Point& target) {
    const ProbeAnswer answer = oracle_.probe(target);
    cost_.probing += (answer.position - at_).norm();
    at_ = answer.position;
    const bool contact = answer.outcome == ProbeAnswer::Outcome::contact;
    ++(contact ? cost_.contact : cost_.clear);
    return contact ? std::optional(answer.position) : std::nullopt;
}

Segment random_chord(const Surroundings& surroundings, std::mt19937_64& random) {
    while (true) {
        const Segment chord = random_chord(Ball{surroundings.region().center(), surroundings.region().radius()}, random);
        const Vector direction = (chord.target - chord.source).normalized();
        if (const auto part = surroundings.unknown_part(chord.source, direction)) {
            return {chord.source + part->low * direction, chord.source + part->high * direction};
        }
    }
}

}  // namespace palpate
