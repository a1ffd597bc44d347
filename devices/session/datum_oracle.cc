#include "devices/session/datum_oracle.h"

#include <cassert>

namespace palpate {

void DatumOracle::travel(std::span<const Point> path, Ground ground) {
    if (!path.empty()) device_.prepare(path.front());
    oracle_.travel(path, ground);
}

ProbeAnswer DatumOracle::probe(const Point& target) {
    device_.prepare(target);
    ProbeAnswer answer = oracle_.probe(target);
    if (answer.outcome == ProbeAnswer::Outcome::contact) noted_.push_back({answer.position, device_.time(), device_.log().shift()});
    return answer;
}

void DatumOracle::take_out_drift(Result& result) const {
    std::vector<Vector> of_sample(result.samples, Vector::Zero());
    auto next = noted_.begin();
    for (Touch& touch : result.touches) {
        if (touch.is_known) continue;
        // Both are in the order in which they were touched; not every touch of the oracle's becomes one of the result's.
        while (next != noted_.end() && next->touched != touch.position) ++next;
        assert(next != noted_.end());
        if (next == noted_.end()) break;
        const Vector change = next->shift - device_.log().at(next->time);
        touch.position += change;
        touch.from += change;
        if (touch.sample) of_sample[*touch.sample] = change;
        ++next;
    }
    for (std::size_t v = 0; v < result.mesh.points.size(); ++v) result.mesh.points[v] += of_sample[result.sample_of[v]];
}

}  // namespace palpate
