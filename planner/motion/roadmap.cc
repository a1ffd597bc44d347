#include "planner/motion/roadmap.h"

#include <algorithm>
#include <cassert>
#include <functional>
#include <limits>
#include <stdexcept>

namespace palpate {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Most ways are a few nodes long: the known way, as a bound, is only worked out for a search that takes longer.
constexpr int kCheapSearch = 16;

}  // namespace

NodeId Roadmap::add_on_boundary(const Point& p) {
    const auto id = static_cast<NodeId>(nodes_.size());
    Node node;
    node.point = p;
    node.way_out = id;
    node.on_boundary = true;
    nodes_.push_back(node);
    return id;
}

NodeId Roadmap::add(NodeId from, const Point& p) {
    const auto id = static_cast<NodeId>(nodes_.size());
    Node node;
    node.point = p;
    node.way_out = from;
    node.way_out_length = nodes_[from].way_out_length + (p - nodes_[from].point).norm();
    nodes_.push_back(node);
    connect(from, id);
    return id;
}

NodeId Roadmap::add(NodeId from, const Destination& to) {
    if (to.node == kNoNode && !to.on_boundary) return add(from, to.position);
    const NodeId node = to.node != kNoNode ? to.node : add_on_boundary(to.position);
    connect(from, node);
    return node;
}

void Roadmap::connect(NodeId a, NodeId b) {
    const double length = (at(a) - at(b)).norm();
    link(a, b, length);
    link(b, a, length);
    offer_way_out(a, b, length);
    offer_way_out(b, a, length);
}

NodeId Roadmap::split(NodeId a, NodeId b, const Point& p) {
    const Vector along = at(b) - at(a);
    const double squared = along.squaredNorm();
    const double share = squared > 0 ? std::clamp((p - at(a)).dot(along) / squared, 0.0, 1.0) : 0.0;
    const auto middle = static_cast<NodeId>(nodes_.size());
    Node node;
    node.point = at(a) + share * along;
    nodes_.push_back(node);
    const double from_a = (at(middle) - at(a)).norm();
    const double from_b = (at(middle) - at(b)).norm();
    relink(a, b, middle);
    relink(b, a, middle);
    link(middle, a, from_a);
    link(middle, b, from_b);
    const bool through_a = nodes_[a].way_out_length + from_a <= nodes_[b].way_out_length + from_b;
    nodes_[middle].way_out = through_a ? a : b;
    nodes_[middle].way_out_length = through_a ? nodes_[a].way_out_length + from_a : nodes_[b].way_out_length + from_b;
    return middle;
}

void Roadmap::link(NodeId from, NodeId to, double length) {
    links_.push_back({to, nodes_[from].first_link, length});
    nodes_[from].first_link = static_cast<std::uint32_t>(links_.size() - 1);
}

void Roadmap::relink(NodeId from, NodeId old_to, NodeId new_to) {
    for (std::uint32_t l = nodes_[from].first_link; l != kNoLink; l = links_[l].next) {
        if (links_[l].to == old_to) {
            links_[l].to = new_to;
            links_[l].length = (at(from) - at(new_to)).norm();
            return;
        }
    }
    throw std::logic_error("Roadmap::split: the two nodes are not joined by a segment");
}

void Roadmap::offer_way_out(NodeId node, NodeId through, double length) {
    if (nodes_[through].way_out_length + length < nodes_[node].way_out_length) {
        nodes_[node].way_out = through;
        nodes_[node].way_out_length = nodes_[through].way_out_length + length;
    }
}

Roadmap::Way Roadmap::known_way(NodeId from, NodeId to) const {
    Way way;
    way.out.push_back(from);
    way.in.push_back(to);
    while (way.out.back() != way.in.back()) {
        // The end that is recorded as farther from the boundary goes on: lengths never grow along a way out.
        const bool advance_out = nodes_[way.out.back()].way_out_length >= nodes_[way.in.back()].way_out_length;
        std::vector<NodeId>* side = advance_out ? &way.out : &way.in;
        if (on_boundary(side->back())) side = advance_out ? &way.in : &way.out;
        if (on_boundary(side->back())) break;
        const NodeId next = nodes_[side->back()].way_out;
        way.length += (at(next) - at(side->back())).norm();
        side->push_back(next);
    }
    if (way.out.back() != way.in.back()) way.length += surroundings_.distance(at(way.out.back()), at(way.in.back()));
    std::reverse(way.in.begin(), way.in.end());
    return way;
}

// A search from both ends at once, each settling nodes in the order of its key
//   key(v) = cost(v) ± p(v),   p(v) = (|v - goal| - |v - start|) / 2,   + from the start, - from the goal.
// p is a consistent potential, and the same for both sides (Ikeda et al. 1994): a way through a node that the start's
// side has not settled and one that the goal's side has not is at least as long as the sum of the two least keys.
struct Roadmap::Search {
    Roadmap& map;
    const Point start;
    const Point goal;
    double best = kInfinity;                                   // length of the best way so far ...
    NodeId out = kNoNode;                                      // ... and where its parts end: the same node, or two on the boundary; ...
    NodeId in = kNoNode;                                       // ... kNoNode: the best is the known way
    std::array<double, 2> boundary_key{kInfinity, kInfinity};  // least key of a settled node on the boundary

    Search(Roadmap& m, NodeId from, NodeId to) : map(m), start(m.at(from)), goal(m.at(to)) {
        ++map.searches_;
        for (const int side : {0, 1}) {
            map.heaps_[index(side)].clear();
            map.boundary_[index(side)].clear();
        }
        push(0, from, kNoNode, 0.0);
        push(1, to, kNoNode, 0.0);
    }

    static std::size_t index(int side) { return static_cast<std::size_t>(side); }
    [[nodiscard]] Label& label(int side, NodeId node) const { return map.nodes_[node].labels[index(side)]; }
    [[nodiscard]] bool has_label(int side, NodeId node) const { return label(side, node).search == map.searches_; }

    [[nodiscard]] double key(int side, NodeId node, double cost) const {
        const double potential = ((map.at(node) - goal).norm() - (map.at(node) - start).norm()) / 2;
        return side == 0 ? cost + potential : cost - potential;
    }

    [[nodiscard]] double least_key(int side) const {
        const auto& heap = map.heaps_[index(side)];
        if (heap.empty()) return kInfinity;
        return heap.front().first;
    }

    // No way that the search has not seen yet can be shorter than this.
    [[nodiscard]] double at_least() const {
        return std::min({least_key(0) + least_key(1), least_key(0) + boundary_key[1], boundary_key[0] + least_key(1)});
    }

    void push(int side, NodeId node, NodeId came_from, double cost) {
        Label& l = label(side, node);
        if (has_label(side, node) && l.cost <= cost) return;
        l = {cost, came_from, map.searches_, false};
        auto& heap = map.heaps_[index(side)];
        heap.emplace_back(key(side, node, cost), node);
        std::push_heap(heap.begin(), heap.end(), std::greater<>());
        if (has_label(1 - side, node)) offer(node, node, cost + label(1 - side, node).cost);
    }

    void offer(NodeId out_end, NodeId in_end, double length) {
        if (length >= best) return;
        best = length;
        out = out_end;
        in = in_end;
    }

    void settle_next(int side) {
        auto& heap = map.heaps_[index(side)];
        std::pop_heap(heap.begin(), heap.end(), std::greater<>());
        const auto [node_key, node] = heap.back();
        heap.pop_back();
        Label& l = label(side, node);
        if (l.settled) return;
        l.settled = true;
        if (map.on_boundary(node)) settle_on_boundary(side, node, node_key);
        const double other_least = std::min(least_key(1 - side), boundary_key[index(1 - side)]);
        for (std::uint32_t k = map.nodes_[node].first_link; k != kNoLink; k = map.links_[k].next) {
            const Link& to = map.links_[k];
            const double cost = l.cost + to.length;
            // A contact is a dead end: one link, back to where we come from.
            const bool dead_end =
                map.links_[map.nodes_[to.to].first_link].next == kNoLink && !has_label(1 - side, to.to) && !map.on_boundary(to.to);
            if (!dead_end && key(side, to.to, cost) + other_least < best) push(side, to.to, node, cost);
        }
    }

    void settle_on_boundary(int side, NodeId node, double node_key) {
        boundary_key[index(side)] = std::min(boundary_key[index(side)], node_key);
        map.boundary_[index(side)].push_back(node);
        for (const NodeId other : map.boundary_[index(1 - side)]) {
            const double inside = label(side, node).cost + label(1 - side, other).cost;
            if (inside + (map.at(node) - map.at(other)).norm() >= best) continue;
            const double length = inside + map.surroundings_.distance(map.at(node), map.at(other));
            side == 0 ? offer(node, other, length) : offer(other, node, length);
        }
    }

    [[nodiscard]] std::vector<NodeId> trace(int side, NodeId node) const {
        std::vector<NodeId> way;
        for (; node != kNoNode; node = label(side, node).came_from) way.push_back(node);
        if (side == 0) std::reverse(way.begin(), way.end());
        return way;
    }
};

Roadmap::Path Roadmap::short_path(NodeId from, NodeId to) {
    Path path;
    if (from == to) return path;
    Search search(*this, from, to);
    Way known;
    for (int settled = 0; search.at_least() < search.best && settled < kMaxSettled; ++settled) {
        if (settled == kCheapSearch) {
            known = known_way(from, to);
            search.offer(kNoNode, kNoNode, known.length);
        }
        // Both sides advance alike; a side with nothing left has told all it can.
        const bool goal_side = settled % 2 == 1;
        search.settle_next(search.least_key(goal_side ? 1 : 0) < kInfinity ? (goal_side ? 1 : 0) : (goal_side ? 0 : 1));
    }
    if (search.out == kNoNode && known.out.empty()) throw std::logic_error("Roadmap: two nodes without a way between them");
    if (search.out != kNoNode) known = {search.trace(0, search.out), search.trace(1, search.in), search.best};

    for (const NodeId node : known.out) path.points.push_back(at(node));
    if (known.out.back() != known.in.front()) {
        const std::vector<Point> outside = surroundings_.path(at(known.out.back()), at(known.in.front()));
        path.points.insert(path.points.end(), outside.begin(), outside.end());
    }
    for (const NodeId node : known.in) path.points.push_back(at(node));
    path.points.erase(std::unique(path.points.begin(), path.points.end()), path.points.end());
    for (std::size_t k = 1; k < path.points.size(); ++k) path.length += (path.points[k] - path.points[k - 1]).norm();
    path.points.erase(path.points.begin());
    return path;
}

std::vector<NodeId> Roadmap::neighbors(NodeId node) const {
    std::vector<NodeId> result;
    for (std::uint32_t l = nodes_[node].first_link; l != kNoLink; l = links_[l].next) result.push_back(links_[l].to);
    return result;
}

bool Roadmap::is_valid() const {
    for (NodeId node = 0; node < nodes_.size(); ++node) {
        NodeId out = node;
        for (std::size_t steps = 0; !nodes_[out].on_boundary; ++steps) {
            if (steps > nodes_.size()) return false;
            out = nodes_[out].way_out;
        }
        for (const NodeId to : neighbors(node)) {
            const std::vector<NodeId> back = neighbors(to);
            if (std::find(back.begin(), back.end(), node) == back.end()) return false;
        }
    }
    return true;
}

}  // namespace palpate
