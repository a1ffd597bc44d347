#include "devices/trail.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <queue>
#include <stdexcept>

namespace palpate {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::array<double, 3> key(const Point& p) { return {p.x(), p.y(), p.z()}; }

}  // namespace

Point nearest_on(const Segment& segment, const Point& p) {
    const Vector way = segment.target - segment.source;
    const double squared = way.squaredNorm();
    const double share = squared > 0 ? std::clamp((p - segment.source).dot(way) / squared, 0.0, 1.0) : 0.0;
    return segment.source + share * way;
}

double distance_to(const Segment& segment, const Point& p) { return (p - nearest_on(segment, p)).norm(); }

Trail::Trail(const Journal& journal) {
    std::map<std::array<double, 3>, std::size_t> known;
    const auto add = [&](const Point& p) {
        const auto [found, is_new] = known.try_emplace(key(p), places_.size());
        if (is_new) {
            places_.push_back(p);
            links_.emplace_back();
        }
        return found->second;
    };
    std::size_t at = add(journal.header.start);
    for (const JournalMove& move : journal.moves) {
        const std::size_t to = add(move.rest);
        if (to == at) continue;
        const double length = (move.rest - places_[at]).norm();
        links_[at].push_back({to, length});
        links_[to].push_back({at, length});
        at = to;
    }
    for (const auto& [coordinates, place] : known) sorted_.push_back(place);
}

std::size_t Trail::place_of(const Point& p) const {
    const auto found = std::lower_bound(sorted_.begin(), sorted_.end(), key(p),
                                        [&](std::size_t place, const auto& sought) { return key(places_[place]) < sought; });
    if (found == sorted_.end() || places_[*found] != p) throw std::invalid_argument("Trail: the tool never rested there");
    return *found;
}

std::vector<Point> Trail::way(const Point& from, const Point& to) const {
    // Dijkstra, from the end, so that the way comes out in order.
    const std::size_t start = place_of(from);
    const std::size_t goal = place_of(to);
    std::vector<double> cost(places_.size(), kInfinity);
    std::vector<std::size_t> next(places_.size(), goal);
    using Entry = std::pair<double, std::size_t>;  // among equals the older place first
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    cost[goal] = 0;
    open.emplace(0.0, goal);
    while (!open.empty() && open.top().second != start) {
        const auto [length, place] = open.top();
        open.pop();
        if (length > cost[place]) continue;
        for (const Link& link : links_[place]) {
            if (length + link.length >= cost[link.to]) continue;
            cost[link.to] = length + link.length;
            next[link.to] = place;
            open.emplace(cost[link.to], link.to);
        }
    }
    std::vector<Point> way;
    for (std::size_t place = start; place != goal;) {
        place = next[place];
        way.push_back(places_[place]);
    }
    return way;
}

std::optional<Segment> Trail::move_near(const Point& p, double tolerance) const {
    std::optional<Segment> nearest;
    double least = tolerance;
    for (std::size_t place = 0; place < places_.size(); ++place) {
        for (const Link& link : links_[place]) {
            const Segment segment{places_[place], places_[link.to]};
            const double distance = distance_to(segment, p);
            if (distance > least || (nearest && distance == least)) continue;
            least = distance;
            nearest = segment;
        }
    }
    return nearest;
}

}  // namespace palpate
