#include "sim/machines/internal/tool_path.h"

#include <algorithm>
#include <cmath>

namespace palpate {

std::vector<Stretch> stretches_of(const Obstacle& obstacle, const Segment& way) {
    const double length = (way.target - way.source).norm();
    std::vector<Stretch> stretches;
    std::vector<Point> cuts = obstacle.crossings(way);
    cuts.push_back(way.target);
    Point last = way.source;
    double from = 0.0;
    for (const Point& cut : cuts) {
        const double to = std::min(length, (cut - way.source).norm());
        // Its middle tells the side; parity would trust that every crossing was found and that none only touches.
        const bool inside = obstacle.contains(0.5 * (last + cut));
        if (stretches.empty()) {
            stretches.push_back({0.0, to, inside});
        } else if (stretches.back().inside == inside) {
            stretches.back().to = to;
        } else if (to > from) {
            stretches.push_back({from, to, inside});
        }
        last = cut;
        from = to;
    }
    return stretches;
}

std::vector<Stretch> felt_of(std::vector<Stretch> stretches, double late, double early) {
    const auto entry = std::ranges::find_if(stretches, [](const Stretch& s) { return s.inside; });
    if (entry == stretches.end()) return stretches;
    const bool comes_out = entry + 1 != stretches.end();
    const double from = std::max(entry->from + late, entry == stretches.begin() ? 0.0 : (entry - 1)->from);
    const double to = entry->to - early;
    std::vector<Stretch> felt(stretches.begin(), entry);
    const auto append = [&](double end, bool inside) {
        if (!felt.empty() && felt.back().inside == inside) {
            felt.back().to = end;
        } else {
            felt.push_back({felt.empty() ? 0.0 : felt.back().to, end, inside});
        }
    };
    if (from < to) {
        if (!felt.empty()) felt.back().to = from;
        if (felt.empty() && from > 0.0) append(from, false);
        append(to, true);
    }
    if (comes_out || early > 0.0 || from >= to) append(entry->to, false);
    std::for_each(entry + 1, stretches.end(), [&](const Stretch& rest) { append(rest.to, rest.inside); });
    return felt;
}

double deepest_between(const Obstacle& obstacle, const Segment& way, double from, double to, double step) {
    constexpr double kMostSteps = 256.0;  // 0.4 % of the way: far finer than what tells a crash from a touch
    const double length = (way.target - way.source).norm();
    if (length == 0.0) return obstacle.depth(way.source);
    const Vector direction = (way.target - way.source) / length;
    const int steps = static_cast<int>(std::clamp(std::ceil((to - from) / step), 1.0, kMostSteps));
    double deepest = 0.0;
    for (int i = 0; i <= steps; ++i) {
        deepest = std::max(deepest, obstacle.depth(way.source + (from + (to - from) * i / steps) * direction));
    }
    return deepest;
}

const Leg& leg_at(const Legs& legs, double distance) {
    const auto leg = std::ranges::find_if(legs, [&](const Leg& l) { return distance < l.to; });
    return leg == legs.end() ? legs.back() : *leg;
}

std::vector<Stretch> stretches_of(const Obstacle& obstacle, const Legs& legs) {
    std::vector<Stretch> all;
    for (const Leg& leg : legs) {
        const double real = (leg.way.target - leg.way.source).norm();
        const double scale = real > 0.0 ? (leg.to - leg.from) / real : 0.0;
        for (const Stretch& stretch : stretches_of(obstacle, leg.way)) {
            // The first and the last of a leg end with it, whatever rounding makes of them.
            const double to = stretch.to < real ? leg.from + stretch.to * scale : leg.to;
            if (!all.empty() && all.back().inside == stretch.inside) {
                all.back().to = to;
            } else {
                all.push_back({leg.from + stretch.from * scale, to, stretch.inside});
            }
        }
    }
    return all;
}

double deepest_between(const Obstacle& obstacle, const Legs& legs, double from, double to, double step) {
    double deepest = 0.0;
    for (const Leg& leg : legs) {
        if (leg.to < from || leg.from > to) continue;
        const double scale = leg.to > leg.from ? (leg.way.target - leg.way.source).norm() / (leg.to - leg.from) : 0.0;
        const auto real = [&](double distance) { return (std::clamp(distance, leg.from, leg.to) - leg.from) * scale; };
        deepest = std::max(deepest, deepest_between(obstacle, leg.way, real(from), real(to), step));
    }
    return deepest;
}

}  // namespace palpate
