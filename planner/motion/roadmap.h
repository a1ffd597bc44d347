// Every segment ever proven free, and short ways on them (planner/DESIGN.md, "Ways").
//
// Nodes on the boundary of ω are joined outside ω by Surroundings::path. The roadmap only grows, and always hangs
// together: a node is made either on the boundary or at the end of a segment from an older node.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "planner/geometry.h"
#include "planner/surroundings.h"

namespace palpate {

using NodeId = std::uint32_t;
inline constexpr NodeId kNoNode = ~NodeId{0};

// Where a straight way from a node leads.
struct Destination {
    Point position = Point::Zero();
    NodeId node = kNoNode;  // that is there already
    bool on_boundary = false;
};

class Roadmap {
public:
    explicit Roadmap(const Surroundings& surroundings) : surroundings_(surroundings) {}

    // A node on the boundary of ω.
    NodeId add_on_boundary(const Point& p);
    // A node at the end of a segment from `from`, which has been proven free.
    NodeId add(NodeId from, const Point& p);
    // The segment from `from` to there has been proven free; returns the node there.
    NodeId add(NodeId from, const Destination& to);
    // Another proven-free segment between two nodes.
    void connect(NodeId a, NodeId b);
    // A node on the segment between a and b (which is then two segments), nearest to `p`.
    NodeId split(NodeId a, NodeId b, const Point& p);

    [[nodiscard]] const Point& at(NodeId node) const { return nodes_[node].point; }
    [[nodiscard]] bool on_boundary(NodeId node) const { return nodes_[node].on_boundary; }
    [[nodiscard]] std::size_t size() const { return nodes_.size(); }

    struct Path {
        std::vector<Point> points;  // to pass in turn, without the start, ending at the goal
        double length = 0.0;        // mm
    };
    // A shortest way among those that leave ω at most once, if that can be told by looking at kMaxSettled nodes; if not,
    // the shortest seen by then, or along the recorded ways out of both ends, whichever is shorter. So a path costs the
    // same however large the roadmap is. Same roadmap, same answer, byte for byte.
    [[nodiscard]] Path short_path(NodeId from, NodeId to);
    static constexpr int kMaxSettled = 400;

    // The nodes joined to one by a segment. For tests.
    [[nodiscard]] std::vector<NodeId> neighbors(NodeId node) const;
    // Checks that segments join nodes both ways and every node has its way out. For tests: linear time.
    [[nodiscard]] bool is_valid() const;

private:
    static constexpr std::uint32_t kNoLink = ~std::uint32_t{0};
    struct Link {
        NodeId to = kNoNode;
        std::uint32_t next = kNoLink;  // of the same node
        double length = 0.0;           // mm
    };
    // What a search knows of a node, from the start (0) or from the goal (1).
    struct Label {
        double cost = 0.0;  // mm
        NodeId came_from = kNoNode;
        std::uint32_t search = 0;  // that wrote this label
        bool settled = false;
    };
    struct Node {
        Point point = Point::Zero();
        std::uint32_t first_link = kNoLink;
        NodeId way_out = kNoNode;     // next node on a known way to the boundary; itself on the boundary
        double way_out_length = 0.0;  // mm: never less than the length of that way
        std::array<Label, 2> labels;
        bool on_boundary = false;
    };
    struct Search;
    // The nodes of a way in two parts: inside ω from the start, and inside ω to the goal; between them outside ω, unless
    // the second part begins where the first ends.
    struct Way {
        std::vector<NodeId> out;
        std::vector<NodeId> in;
        double length = 0.0;
    };

    void link(NodeId from, NodeId to, double length);
    void relink(NodeId from, NodeId old_to, NodeId new_to);
    void offer_way_out(NodeId node, NodeId through, double length);
    // Along the recorded ways out of both ends, up to where they meet.
    [[nodiscard]] Way known_way(NodeId from, NodeId to) const;

    const Surroundings surroundings_;
    std::vector<Node> nodes_;
    std::vector<Link> links_;
    std::uint32_t searches_ = 0;
    std::array<std::vector<std::pair<double, NodeId>>, 2> heaps_;  // scratch of a search
    std::array<std::vector<NodeId>, 2> boundary_;
};

}  // namespace palpate
