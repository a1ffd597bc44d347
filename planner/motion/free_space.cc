#include "planner/motion/free_space.h"

#include <algorithm>
#include <functional>
#include <limits>

namespace palpate {

Point FreeSpace::hover_point(std::uint32_t sample) const {
    const Point& apex = state_.sample(sample);
    const Vector up = model_.normal(sample);
    const auto chord = state_.surroundings().unknown_part(apex, up);
    return apex + (chord ? std::min(hover_, chord->high) : hover_) * up;
}

bool FreeSpace::is_free(const Point& from, const Point& to, std::span<const std::uint32_t> lenses) const {
    const double length = (to - from).norm();
    if (length == 0) return true;
    const Vector direction = (to - from) / length;
    covered_.clear();
    for (const std::uint32_t sample : lenses) {
        if (!model_.has_clearance(sample)) continue;
        const std::optional<Interval> inside = model_.clearance(sample).clip(from, direction);
        if (inside) covered_.push_back(*inside);
    }
    std::sort(covered_.begin(), covered_.end(), [](const Interval& x, const Interval& y) { return x.low < y.low; });
    double reached = 0;
    for (const Interval& inside : covered_) {
        if (inside.low >= reached && reached > 0) break;
        if (inside.low < 0 || reached > 0) reached = std::max(reached, inside.high);
    }
    return reached > length;
}

bool FreeSpace::reach(std::uint32_t sample, double cost, std::uint32_t came_from, const Point& goal) {
    Label& label = labels_[sample];
    if (label.search == searches_ && (label.settled || label.cost <= cost)) return false;
    const double estimate = cost + (hover_point(sample) - goal).norm();
    if (estimate > at_most_) return false;
    label = {cost, came_from, searches_, false};
    heap_.emplace_back(estimate, sample);
    std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
    return true;
}

std::optional<std::vector<std::uint32_t>> FreeSpace::hover_way(const HoverPlace& from, const HoverPlace& to) {
    constexpr std::uint32_t kStart = ~std::uint32_t{0};
    labels_.resize(state_.sample_count());
    ++searches_;
    heap_.clear();
    state_.adjacent_samples(from.home, adjacent_);
    adjacent_.push_back(from.home);
    for (const std::uint32_t sample : adjacent_) {
        if (!model_.has_clearance(sample)) continue;
        const Point first = hover_point(sample);
        const std::array<std::uint32_t, 2> lenses{sample, from.home};
        if (is_free(from.point, first, lenses)) reach(sample, (first - from.point).norm(), kStart, to.point);
    }
    while (!heap_.empty()) {
        std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
        const std::uint32_t at = heap_.back().second;
        heap_.pop_back();
        if (labels_[at].settled) continue;
        labels_[at].settled = true;
        if (at == to.home) {
            std::vector<std::uint32_t> samples;
            for (std::uint32_t s = at; s != kStart; s = labels_[s].came_from) samples.push_back(s);
            std::reverse(samples.begin(), samples.end());
            return samples;
        }
        const double cost = labels_[at].cost;
        const Point here = hover_point(at);
        state_.adjacent_samples(at, adjacent_);
        for (const std::uint32_t next : adjacent_) {
            if (!model_.has_clearance(next)) continue;
            const Label& label = labels_[next];
            const Point there = hover_point(next);
            const double longer = cost + (there - here).norm();
            if (label.search == searches_ && (label.settled || label.cost <= longer)) continue;
            const std::array<std::uint32_t, 2> lenses{at, next};
            if (is_free(here, there, lenses)) reach(next, longer, at, to.point);
        }
    }
    return std::nullopt;
}

std::optional<FreeSpace::Way> FreeSpace::way(const HoverPlace& from, const HoverPlace& to, double at_most) {
    at_most_ = at_most;
    Way way;
    std::vector<std::uint32_t> lenses;  // that the way may lead through
    state_.adjacent_samples(to.home, lenses);
    lenses.push_back(to.home);
    lenses.push_back(from.home);
    if (is_free(from.point, to.point, lenses)) {
        way.stops = {to};
        way.length = (to.point - from.point).norm();
        return way;
    }
    const std::optional<std::vector<std::uint32_t>> samples = hover_way(from, to);
    if (!samples) return std::nullopt;
    std::vector<HoverPlace> corners;
    for (const std::uint32_t s : *samples) corners.push_back({hover_point(s), s});
    corners.push_back(to);
    lenses.insert(lenses.end(), samples->begin(), samples->end());
    // Straight on to the farthest corner that the lenses along the way allow.
    Point at = from.point;
    for (std::size_t k = 0; k < corners.size(); ++k) {
        std::size_t farthest = corners.size() - 1;
        while (farthest > k && !is_free(at, corners[farthest].point, lenses)) --farthest;
        way.stops.push_back(corners[farthest]);
        way.length += (corners[farthest].point - at).norm();
        at = corners[farthest].point;
        k = farthest;
    }
    return way;
}

}  // namespace palpate
