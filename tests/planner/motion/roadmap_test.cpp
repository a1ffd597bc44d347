#include "planner/motion/roadmap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <string>

#include "tests/planner/support.h"

namespace palpate::roadmap_test {
namespace {

constexpr std::uint64_t kSeed = 20240613;
constexpr double kTolerance = 1e-10;  // of ω's radius
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A roadmap grown as the planner grows it: chords from one boundary point to another, dead ends, loops, splits. Keeps its own
// list of segments, as they are and as they were.
class Growing {
public:
    Growing(const Region& workspace, std::uint64_t seed) : workspace_(workspace), map_(workspace), random_(seed) {
        map_.add_on_boundary(random_.on_boundary(workspace));
    }

    void step() {
        const double what = random_.uniform(0, 1);
        if (what < 0.2) {
            // A probe across ω, from outside to outside or to a dead end inside.
            const NodeId entry = map_.add_on_boundary(random_.on_boundary(workspace_));
            const Point leave = random_.on_boundary(workspace_);
            if (random_.chance(0.5)) {
                const NodeId out = map_.add_on_boundary(leave);
                connect(entry, out);
            } else {
                add(entry, map_.at(entry) + random_.uniform(0, 1) * (leave - map_.at(entry)));
            }
        } else if (what < 0.65) {
            // On from some node; short steps make the many small pieces of a run.
            const NodeId from = any_node();
            const double share = random_.chance(0.5) ? random_.uniform(0, 1) : std::pow(10, random_.uniform(-4, 0));
            add(from, map_.at(from) + share * (inner_point() - map_.at(from)));
        } else if (what < 0.8) {
            const NodeId a = any_node();
            const NodeId b = any_node();
            if (a != b && !joined(a, b)) connect(a, b);
        } else if (!segments_.empty()) {
            auto& segment = segments_[random_.below(segments_.size())];
            const auto [a, b] = segment;
            const NodeId middle = map_.split(a, b, inner_point());
            segment = {a, middle};
            segments_.emplace_back(middle, b);
        }
    }

    [[nodiscard]] NodeId any_node() { return static_cast<NodeId>(random_.below(map_.size())); }
    [[nodiscard]] Roadmap& map() { return map_; }
    [[nodiscard]] const std::vector<std::pair<NodeId, NodeId>>& segments() const { return segments_; }
    // As they were proven free, before they were split.
    [[nodiscard]] const std::vector<std::pair<NodeId, NodeId>>& proven() const { return proven_; }

private:
    Point inner_point() {
        return workspace_.center() + std::cbrt(random_.uniform(0, 1)) * 0.57 * workspace_.radius() * random_.direction();
    }
    bool joined(NodeId a, NodeId b) const {
        return std::any_of(segments_.begin(), segments_.end(), [&](const auto& s) { return s == std::pair{a, b} || s == std::pair{b, a}; });
    }
    void add(NodeId from, const Point& p) {
        segments_.emplace_back(from, map_.add(from, p));
        proven_.push_back(segments_.back());
    }
    void connect(NodeId a, NodeId b) {
        map_.connect(a, b);
        segments_.emplace_back(a, b);
        proven_.push_back(segments_.back());
    }

    Region workspace_;
    Roadmap map_;
    Random random_;
    std::vector<std::pair<NodeId, NodeId>> segments_;
    std::vector<std::pair<NodeId, NodeId>> proven_;
};

// Lengths of the shortest ways from a node that leave ω at most once, by Dijkstra's algorithm on two layers: before and
// after the way outside, for which every two nodes on the boundary are joined.
std::vector<double> brute_force(const Region& workspace, Growing& growing, NodeId start) {
    const Roadmap& map = growing.map();
    const std::size_t n = map.size();
    std::vector<std::vector<std::pair<std::size_t, double>>> links(2 * n);
    for (const auto& [a, b] : growing.segments()) {
        const double length = (map.at(a) - map.at(b)).norm();
        for (const std::size_t layer : {std::size_t{0}, n}) {
            links[layer + a].emplace_back(layer + b, length);
            links[layer + b].emplace_back(layer + a, length);
        }
    }
    for (NodeId a = 0; a < n; ++a) {
        links[a].emplace_back(n + a, 0);
        for (NodeId b = 0; b < n; ++b) {
            if (map.on_boundary(a) && map.on_boundary(b))
                links[a].emplace_back(n + b, Surroundings(workspace).distance(map.at(a), map.at(b)));
        }
    }
    std::vector<double> cost(2 * n, kInfinity);
    std::priority_queue<std::pair<double, std::size_t>, std::vector<std::pair<double, std::size_t>>, std::greater<>> heap;
    cost[start] = 0;
    heap.emplace(0, start);
    while (!heap.empty()) {
        const auto [at, node] = heap.top();
        heap.pop();
        if (at > cost[node]) continue;
        for (const auto& [to, length] : links[node]) {
            if (at + length < cost[to]) heap.emplace(cost[to] = at + length, to);
        }
    }
    return {cost.begin() + static_cast<std::ptrdiff_t>(n), cost.end()};
}

bool lies_on(const Point& p, const Point& a, const Point& b, double tolerance) {
    const double squared = (b - a).squaredNorm();
    const double share = squared > 0 ? std::clamp((p - a).dot(b - a) / squared, 0.0, 1.0) : 0;
    return (a + share * (b - a) - p).norm() <= tolerance;
}

// Every piece of the path lies on one segment that was proven free, or outside ω.
void expect_valid_walk(const Region& workspace, Growing& growing, NodeId from, NodeId to, const Roadmap::Path& path) {
    const Roadmap& map = growing.map();
    const double tolerance = kTolerance * workspace.radius();
    if (from == to) {
        ASSERT_TRUE(path.points.empty());
        ASSERT_EQ(path.length, 0);
        return;
    }
    if (!path.points.empty()) {
        ASSERT_EQ(path.points.back(), map.at(to));
    } else {
        ASSERT_EQ(map.at(from), map.at(to));
    }
    double length = 0;
    Point last = map.at(from);
    for (const Point& p : path.points) {
        length += (p - last).norm();
        const bool on_segment = std::any_of(growing.proven().begin(), growing.proven().end(), [&](const auto& s) {
            return lies_on(last, map.at(s.first), map.at(s.second), tolerance) && lies_on(p, map.at(s.first), map.at(s.second), tolerance);
        });
        if (!on_segment) {
            for (int k = 0; k <= 16; ++k)
                ASSERT_LE(depth(workspace, last + k / 16.0 * (p - last)), tolerance) << "neither proven free nor outside";
        }
        last = p;
    }
    ASSERT_NEAR(path.length, length, tolerance);
}

class RoadmapOnBothShapes : public testing::TestWithParam<const char*> {
protected:
    [[nodiscard]] static Region workspace_of_test() {
        if (std::string(GetParam()) == "ball") return Region(Ball{{1, 2, 3}, 10});
        return Region(Box{{-4, 0, 1}, {4, 12, 9}});
    }
};
INSTANTIATE_TEST_SUITE_P(Shapes, RoadmapOnBothShapes, testing::Values("ball", "box"),
                         [](const auto& shape) { return std::string(shape.param); });

TEST_P(RoadmapOnBothShapes, ShortPathIsOptimalOnAFewNodes) {
    const Region workspace = workspace_of_test();
    for (std::uint64_t seed = kSeed; seed < kSeed + 60; ++seed) {
        SCOPED_TRACE(seed_text(seed));
        Growing growing(workspace, seed);
        for (int k = 0; k < 70; ++k) {
            growing.step();
            ASSERT_TRUE(growing.map().is_valid());
        }
        // Well below kMaxSettled, from both ends together: the search ends by itself.
        ASSERT_LT(2 * growing.map().size(), static_cast<std::size_t>(Roadmap::kMaxSettled));
        for (int k = 0; k < 4; ++k) {
            const NodeId from = growing.any_node();
            const std::vector<double> best = brute_force(workspace, growing, from);
            for (NodeId to = 0; to < growing.map().size(); ++to) {
                const Roadmap::Path path = growing.map().short_path(from, to);
                expect_valid_walk(workspace, growing, from, to, path);
                if (HasFatalFailure()) return;
                ASSERT_NEAR(path.length, best[to], kTolerance * workspace.radius()) << "from " << from << " to " << to;
            }
        }
    }
}

TEST_P(RoadmapOnBothShapes, ShortPathOnManyNodesIsAWalkNoShorterThanOptimal) {
    const Region workspace = workspace_of_test();
    for (std::uint64_t seed = kSeed; seed < kSeed + 4; ++seed) {
        SCOPED_TRACE(seed_text(seed));
        Growing growing(workspace, seed);
        for (int k = 0; k < 1200; ++k) growing.step();
        ASSERT_TRUE(growing.map().is_valid());
        double sum = 0;
        double best_sum = 0;
        for (int k = 0; k < 2; ++k) {
            const NodeId from = growing.any_node();
            const std::vector<double> best = brute_force(workspace, growing, from);
            for (int j = 0; j < 100; ++j) {
                const NodeId to = growing.any_node();
                const Roadmap::Path path = growing.map().short_path(from, to);
                expect_valid_walk(workspace, growing, from, to, path);
                if (HasFatalFailure()) return;
                ASSERT_GE(path.length, best[to] - kTolerance * workspace.radius());
                sum += path.length;
                best_sum += best[to];
            }
        }
        // Not a contract, but a search that forgets good ways would show here.
        EXPECT_LE(sum, 1.2 * best_sum);
    }
}

// However many nodes lure the search elsewhere, the way by which the tool came is a bound.
TEST(Roadmap, ShortPathIsNeverLongerThanTheKnownWay) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    const Region workspace(Ball{{0, 0, 0}, 10});
    Roadmap map(workspace);
    std::vector<NodeId> came_from;
    std::vector<double> way_out;
    const NodeId entry = map.add_on_boundary({0, 0, 10});
    came_from.push_back(kNoNode);
    way_out.push_back(0);
    const auto add = [&](NodeId from, const Point& p) {
        const NodeId node = map.add(from, p);
        came_from.push_back(from);
        way_out.push_back(way_out[from] + (p - map.at(from)).norm());
        return node;
    };
    // A thicket of small steps around every node: more than a search may settle.
    NodeId last = add(entry, {0, 0, 5});
    std::vector<NodeId> trunk = {entry, last};
    for (int k = 0; k < 60; ++k) {
        last = add(last, map.at(last) + 0.5 * random.direction());
        trunk.push_back(last);
        NodeId twig = last;
        for (int j = 0; j < 60; ++j) twig = add(random.chance(0.3) ? last : twig, map.at(twig) + 0.05 * random.direction());
    }
    ASSERT_TRUE(map.is_valid());
    const auto meet = [&](NodeId a, NodeId b) {  // the tree's own way
        std::vector<bool> above(map.size());
        for (NodeId x = a; x != kNoNode; x = came_from[x]) above[x] = true;
        while (!above[b]) b = came_from[b];
        return b;
    };
    for (int k = 0; k < 500; ++k) {
        const NodeId from = k % 2 == 0 ? random.one_of(trunk) : static_cast<NodeId>(random.below(map.size()));
        const NodeId to = k % 3 == 0 ? random.one_of(trunk) : static_cast<NodeId>(random.below(map.size()));
        const NodeId top = meet(from, to);
        const double known = way_out[from] + way_out[to] - 2 * way_out[top];
        // A tree has one way only: the known one.
        ASSERT_NEAR(map.short_path(from, to).length, known, 1e-9) << "from " << from << " to " << to;
    }
}

TEST_P(RoadmapOnBothShapes, SameGrowthSamePathsByteForByte) {
    const Region workspace = workspace_of_test();
    SCOPED_TRACE(seed_text(kSeed));
    Growing first(workspace, kSeed);
    Growing second(workspace, kSeed);
    for (int k = 0; k < 600; ++k) {
        first.step();
        second.step();
    }
    ASSERT_EQ(first.map().size(), second.map().size());
    for (int k = 0; k < 200; ++k) {
        const NodeId from = first.any_node();
        const NodeId to = first.any_node();
        const Roadmap::Path one = first.map().short_path(from, to);
        ASSERT_EQ(one.points, first.map().short_path(from, to).points) << "asked twice";
        const Roadmap::Path other = second.map().short_path(from, to);
        ASSERT_EQ(one.points, other.points);
        ASSERT_EQ(one.length, other.length);
    }
}

TEST(Roadmap, SplitPutsANodeOnTheSegmentNearestToThePoint) {
    Roadmap map(Region(Ball{{0, 0, 0}, 10}));
    const NodeId entry = map.add_on_boundary({0, 0, 10});
    const NodeId end = map.add(entry, {0, 0, 2});
    const NodeId middle = map.split(entry, end, {1, 1, 5});
    EXPECT_TRUE(map.at(middle).isApprox(Point(0, 0, 5), 1e-15));
    EXPECT_FALSE(map.on_boundary(middle));
    EXPECT_EQ(map.neighbors(entry), std::vector<NodeId>{middle});
    EXPECT_EQ(map.neighbors(end), std::vector<NodeId>{middle});
    EXPECT_EQ(map.at(map.split(entry, middle, {0, 0, 20})), Point(0, 0, 10)) << "not beyond the segment's end";
    EXPECT_TRUE(map.is_valid());
    EXPECT_THROW(map.split(entry, end, {0, 0, 7}), std::logic_error) << "the two are no longer joined";
}

TEST(Roadmap, GoesAroundOutsideWhenThatIsShorter) {
    Roadmap map(Region(Ball{{0, 0, 0}, 1}));
    const NodeId a = map.add_on_boundary({1, 0, 0});
    const NodeId b = map.add_on_boundary({0, 1, 0});
    const double around = Surroundings(Region(Ball{{0, 0, 0}, 1})).distance({1, 0, 0}, {0, 1, 0});
    EXPECT_DOUBLE_EQ(map.short_path(a, b).length, around);
    const NodeId far = map.add(b, {-1, 0, 0});
    EXPECT_NEAR(map.short_path(a, far).length, around + std::sqrt(2.0), 1e-12);
    map.connect(a, b);
    EXPECT_DOUBLE_EQ(map.short_path(a, b).length, std::sqrt(2.0));
    EXPECT_EQ(map.short_path(a, b).points, std::vector<Point>({{0, 1, 0}}));
    EXPECT_TRUE(map.short_path(b, b).points.empty());
}

}  // namespace
}  // namespace palpate::roadmap_test
