#include "devices/session/way_out.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <queue>
#include <unordered_map>
#include <utility>

#include "devices/errors.h"
#include "planner/number_text.h"

namespace palpate {

WayOut::WayOut(const Surroundings& surroundings, const Point& start) : surroundings_(surroundings), slack_(surroundings.boundary_slack()) {
    at_ = index_of(start);
}

void WayOut::add(const Point& rest) {
    const std::size_t to = index_of(rest);
    if (to == at_) return;
    links_[at_].push_back(to);
    links_[to].push_back(at_);
    at_ = to;
}

std::vector<Point> WayOut::way() const {
    if (is_outside_[at_]) return {};
    using Entry = std::pair<double, std::size_t>;  // among equals the older place first
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    std::unordered_map<std::size_t, std::pair<double, std::size_t>> reached;  // mm, and from where
    reached[at_] = {0.0, at_};
    open.emplace(0.0, at_);
    while (!open.empty()) {
        const auto [length, place] = open.top();
        open.pop();
        if (length > reached[place].first) continue;
        if (is_outside_[place]) {
            std::vector<Point> way;
            for (std::size_t p = place; p != at_; p = reached[p].second) way.push_back(places_[p]);
            std::ranges::reverse(way);
            return way;
        }
        for (const std::size_t next : links_[place]) {
            const double whole = length + (places_[next] - places_[place]).norm();
            const auto [found, is_new] = reached.try_emplace(next, whole, place);
            if (!is_new && found->second.first <= whole) continue;
            found->second = {whole, place};
            open.emplace(whole, next);
        }
    }
    throw PositionLost(fmt::format("no way is known from {} out of the workspace", point_text(place())));
}

std::size_t WayOut::index_of(const Point& p) {
    const auto [found, is_new] = known_.try_emplace({p.x(), p.y(), p.z()}, places_.size());
    if (is_new) {
        places_.push_back(p);
        is_outside_.push_back(is_outside(p));
        links_.emplace_back();
    }
    return found->second;
}

bool WayOut::is_outside(const Point& p) const { return surroundings_.is_free(p) || (surroundings_.nearest_entry(p) - p).norm() <= slack_; }

}  // namespace palpate
