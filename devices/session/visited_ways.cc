#include "devices/session/visited_ways.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <queue>
#include <stdexcept>

#include "devices/errors.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Every one of them is joined to every other; more would cost more and hardly shorten a way.
constexpr std::size_t kMaxOutside = 200;
// A way that nothing was touched on since may be the last of a dead probe, through the part: it is gone back where no other leads.
constexpr double kUnconfirmed = 1e4;

std::array<double, 3> key(const Point& p) { return {p.x(), p.y(), p.z()}; }

}  // namespace

VisitedWays::VisitedWays(const Journal& journal, const Surroundings& surroundings, const std::vector<Contradiction>& contradictions)
    : surroundings_(surroundings) {
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
    const std::size_t confirmed = journal.confirmed_moves();
    for (std::size_t k = 0; k < journal.moves.size(); ++k) {
        const Point& rest = journal.moves[k].rest;
        const std::size_t to = add(rest);
        if (to == at) continue;
        const auto is_contradicted = [&](const Contradiction& c) {
            return k >= c.first && k < c.last && distance_to({places_[at], rest}, c.touched) <= c.tolerance;
        };
        if (std::any_of(contradictions.begin(), contradictions.end(), is_contradicted)) {
            at = to;
            continue;
        }
        const double length = (rest - places_[at]).norm() * (k < confirmed ? 1.0 : kUnconfirmed);
        links_[at].push_back({to, length});
        links_[to].push_back({at, length});
        at = to;
    }
    for (const auto& [coordinates, place] : known) sorted_.push_back(place);
    is_outside_.resize(places_.size());
    const double slack = surroundings_.boundary_slack();
    for (std::size_t place = 0; place < places_.size() && outside_.size() < kMaxOutside; ++place) {
        const Point& p = places_[place];
        if (!surroundings_.is_free(p) && (surroundings_.nearest_entry(p) - p).norm() > slack) continue;
        outside_.push_back(place);
        is_outside_[place] = true;
    }
}

std::optional<std::size_t> VisitedWays::find(const Point& p) const {
    const auto found = std::lower_bound(sorted_.begin(), sorted_.end(), key(p),
                                        [&](std::size_t place, const auto& sought) { return key(places_[place]) < sought; });
    if (found == sorted_.end() || places_[*found] != p) return std::nullopt;
    return *found;
}

std::size_t VisitedWays::place_of(const Point& p) const {
    const auto found = find(p);
    if (!found) throw std::invalid_argument("Trail: the tool never rested there");
    return *found;
}

double VisitedWays::outer_distance(std::size_t a, std::size_t b) const {
    const Point out = surroundings_.nearest_entry(places_[a]);
    const Point in = surroundings_.nearest_entry(places_[b]);
    return (out - places_[a]).norm() + surroundings_.distance(out, in) + (places_[b] - in).norm();
}

// Dijkstra, from the end, so that a way comes out in order.
VisitedWays::Ways VisitedWays::ways_to(std::size_t goal, std::optional<std::size_t> start) const {
    Ways ways{std::vector<double>(places_.size(), kInfinity), std::vector<std::size_t>(places_.size(), goal)};
    using Entry = std::pair<double, std::size_t>;  // among equals the older place first
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    ways.cost[goal] = 0;
    open.emplace(0.0, goal);
    const auto offer = [&](std::size_t to, std::size_t through, double length) {
        if (length >= ways.cost[to]) return;
        ways.cost[to] = length;
        ways.next[to] = through;
        open.emplace(length, to);
    };
    while (!open.empty() && (!start || open.top().second != *start)) {
        const auto [length, place] = open.top();
        open.pop();
        if (length > ways.cost[place]) continue;
        for (const Link& link : links_[place]) offer(link.to, place, length + link.length);
        if (!is_outside_[place]) continue;
        for (const std::size_t other : outside_) {
            if (other != place) offer(other, place, length + outer_distance(other, place));
        }
    }
    return ways;
}

bool VisitedWays::has_way(const Point& from, const Point& to) const {
    const auto start = find(from);
    const auto goal = find(to);
    return start && goal && ways_to(*goal, start).cost[*start] < kInfinity;
}

std::vector<Point> VisitedWays::way(const Point& from, const Point& to) const {
    const std::size_t start = place_of(from);
    const std::size_t goal = place_of(to);
    const Ways ways = ways_to(goal, start);
    if (ways.cost[start] == kInfinity) throw PositionLost(fmt::format("no way is left from {} to {}", point_text(from), point_text(to)));
    std::vector<Point> way;
    for (std::size_t place = start; place != goal;) {
        const std::size_t next = ways.next[place];
        const bool is_made = std::any_of(links_[place].begin(), links_[place].end(), [&](const Link& link) { return link.to == next; });
        if (!is_made) {
            const Point out = surroundings_.nearest_entry(places_[place]);
            const Point in = surroundings_.nearest_entry(places_[next]);
            way.push_back(out);
            const std::vector<Point> around = surroundings_.path(out, in);
            way.insert(way.end(), around.begin(), around.end());
        }
        place = next;
        way.push_back(places_[place]);
    }
    return way;
}

std::vector<double> VisitedWays::lengths(const Point& from, const std::vector<Point>& to) const {
    const Ways ways = ways_to(place_of(from), {});
    std::vector<double> lengths;
    for (const Point& p : to) {
        const auto place = find(p);
        lengths.push_back(place ? ways.cost[*place] : kInfinity);
    }
    return lengths;
}

std::optional<Segment> VisitedWays::move_near(const Point& p, double tolerance) const {
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
