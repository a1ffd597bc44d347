#include "planner/delaunay/edge_record.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>

#include "tests/planner/support.h"

namespace palpate::edge_record_test {
namespace {

constexpr std::uint64_t kSeed = 20240614;

// A 1-D model. The old edge is [0, 1], u at 0 and w at 1; the new cell takes everything beyond v. S meets the edge at
// the sorted parameters `crossings`, where it changes sides.
struct Truth {
    std::vector<double> crossings;
    bool u_inside = false;

    [[nodiscard]] bool inside(double t) const {
        const auto before = std::lower_bound(crossings.begin(), crossings.end(), t) - crossings.begin();
        return (before % 2 == 1) != u_inside;
    }
    [[nodiscard]] bool touches(double low, double high) const {
        return std::any_of(crossings.begin(), crossings.end(), [&](double c) { return low <= c && c <= high; });
    }
};

struct Record {
    EdgeState state = EdgeState::unknown;
    Crossing crossing;
    [[nodiscard]] const Crossing* pointer() const { return state == EdgeState::crossing ? &crossing : nullptr; }
    [[nodiscard]] double from() const { return crossing.from.x(); }
    [[nodiscard]] double near() const { return crossing.near.x(); }
    [[nodiscard]] double far() const { return crossing.far.x(); }
    // Proven free by this record: [low, high] of the edge.
    [[nodiscard]] std::optional<Interval> free() const {
        if (state == EdgeState::unknown) return std::nullopt;
        if (state == EdgeState::clear) return Interval{0, 1};
        return Interval{std::min(from(), near()), std::max(from(), near())};
    }
};

Point at(double t) { return {t, 0, 0}; }

// What a search from the end `end` (0 or 1) may have found: nothing, or a touch or a gap, from the vertex or from within.
Record random_record(Random& random, const Truth& truth, double end) {
    Record record;
    const int what = static_cast<int>(random.below(5));
    const bool from_vertex = what == 1 || what == 2;
    if (what == 0) return record;
    const double from = from_vertex ? end : random.uniform(0, 1);
    if (truth.inside(from)) return record;
    // The first crossing beyond `from`, away from the end.
    std::optional<double> first;
    std::optional<double> second;
    for (const double c : truth.crossings) {
        if (end == 0 && c > from && !first) {
            first = c;
        } else if (end == 0 && c > from && !second) {
            second = c;
        }
        if (end == 1 && c < from) {
            second = first;
            first = c;
        }
    }
    if (!first) return record;
    record.state = EdgeState::crossing;
    record.crossing.from_vertex = from_vertex;
    record.crossing.from = at(from);
    record.crossing.near = record.crossing.far = at(*first);
    if (what == 2 || what == 4) {  // inferred: a gap around the crossing, its far end inside O
        record.crossing.inferred = true;
        record.crossing.near = at(*first + random.uniform(0, 1) * (from - *first));
        record.crossing.far = at(*first + random.uniform(0, 1) * (second.value_or(1 - end) - *first));
    }
    return record;
}

std::string describe(const Truth& truth, const Record& u, const Record& w, double v) {
    std::string text = "S at";
    for (const double c : truth.crossings) text += " " + std::to_string(c);
    for (const Record* r : {&u, &w}) {
        text += r == &u ? "; u: " : "; w: ";
        if (r->state != EdgeState::crossing) text += r->state == EdgeState::clear ? "clear" : "unknown";
        if (r->state == EdgeState::crossing) {
            text += (r->crossing.from_vertex ? "from vertex " : "from within ") + std::to_string(r->from()) + ", near " +
                    std::to_string(r->near()) + ", far " + std::to_string(r->far());
        }
    }
    return text + "; v at " + std::to_string(v);
}

bool covered(const std::vector<Interval>& free, double low, double high) {
    // There are at most two intervals: one that reaches from `low`, and maybe one that goes on.
    double reached = low;
    for (int k = 0; k < 2; ++k) {
        for (const Interval& i : free) {
            if (i.low <= reached && i.high > reached) reached = i.high;
        }
    }
    return reached >= high;
}

TEST(CropEdge, ClaimsNothingThatIsNotProvenAndLosesNothingThatCanBeKept) {
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    int freed = 0;
    int kept_u = 0;
    int kept_w = 0;
    int became_vertex = 0;
    for (int i = 0; i < 100000; ++i) {
        Truth truth;
        truth.u_inside = random.chance(0.3);
        for (std::size_t k = random.below(4); k > 0; --k) truth.crossings.push_back(random.uniform(0, 1));
        std::sort(truth.crossings.begin(), truth.crossings.end());
        Record u = random_record(random, truth, 0);
        Record w = random_record(random, truth, 1);
        if (truth.crossings.empty() && !truth.u_inside && random.chance(0.5)) u.state = w.state = EdgeState::clear;
        const double v = random.uniform(0, 1);
        SCOPED_TRACE(describe(truth, u, w, v));

        std::vector<Interval> free;
        for (const Record* r : {&u, &w}) {
            if (const auto part = r->free()) free.push_back(*part);
        }
        // The model itself: nothing proven free holds a crossing but at its end, or lies inside.
        for (const Interval& part : free) ASSERT_FALSE(truth.touches(part.low + 1e-12, part.high - 1e-12));

        const CroppedEdge cropped = crop_edge(u.state, u.pointer(), w.state, w.pointer(), [&](const Point& x) { return x.x() > v; });

        // What is claimed about v and about the edge u–v as a whole is exactly what is proven.
        const bool v_proven = std::any_of(free.begin(), free.end(), [&](const Interval& f) { return f.low <= v && v <= f.high; });
        const bool all_proven = covered(free, 0, v);
        ASSERT_EQ(cropped.frees_v, v_proven);
        ASSERT_EQ(cropped.from_u == EdgeState::clear, all_proven);
        ASSERT_EQ(cropped.from_v == EdgeState::clear, all_proven);
        if (cropped.frees_v) {
            const std::optional<Interval> segment = (cropped.on_segment_of_u ? u : w).free();
            ASSERT_TRUE(segment && segment->low <= v && v <= segment->high) << "v is not on the segment that is named";
        }
        // A crossing stays with its end as long as all of it is on what remains.
        const auto remains = [&](const Record& r) { return r.state == EdgeState::crossing && r.near() <= v && r.far() <= v; };
        ASSERT_EQ(cropped.from_u == EdgeState::crossing, remains(u));
        ASSERT_EQ(cropped.from_v == EdgeState::crossing, remains(w));
        if (cropped.from_v == EdgeState::crossing) {
            // It is w's, and counts as seen from the new vertex exactly if everything between the two is proven free.
            ASSERT_EQ(cropped.from_v_becomes_vertex, covered(w.free() ? std::vector<Interval>{*w.free()} : free, w.near(), v));
            ASSERT_TRUE(cropped.from_v_becomes_vertex || w.from() <= v) << "seen from beyond the edge";
            // First from its end: S does not meet the part between.
            if (cropped.from_v_becomes_vertex) {
                ASSERT_FALSE(truth.touches(w.near() + 1e-12, v));
            }
            ++kept_w;
            became_vertex += cropped.from_v_becomes_vertex ? 1 : 0;
        }
        if (cropped.frees_v) {
            ASSERT_FALSE(truth.inside(v));
        }
        freed += cropped.frees_v ? 1 : 0;
        kept_u += cropped.from_u == EdgeState::crossing ? 1 : 0;
    }
    // The model reaches everything.
    for (const int count : {freed, kept_u, kept_w, became_vertex}) EXPECT_GT(count, 2500);
}

// planner/DESIGN.md, "Insertion", line by line.
class CropEdgeByTheBook : public testing::Test {
protected:
    static Crossing touched(double c, double from, bool from_vertex) {
        Crossing crossing;
        crossing.near = crossing.far = at(c);
        crossing.from = at(from);
        crossing.from_vertex = from_vertex;
        return crossing;
    }
    static CroppedEdge crop(const Crossing* u, const Crossing* w) {
        const auto state = [](const Crossing* c) { return c != nullptr ? EdgeState::crossing : EdgeState::unknown; };
        return crop_edge(state(u), u, state(w), w, [](const Point& x) { return x.x() > 0.5; });
    }
};

TEST_F(CropEdgeByTheBook, NothingKnownNothingGained) {
    const CroppedEdge cropped = crop(nullptr, nullptr);
    EXPECT_EQ(cropped.from_u, EdgeState::unknown);
    EXPECT_EQ(cropped.from_v, EdgeState::unknown);
    EXPECT_FALSE(cropped.frees_v);
}

TEST_F(CropEdgeByTheBook, AClearEdgeStaysClearAndFreesTheVertex) {
    const CroppedEdge cropped = crop_edge(EdgeState::clear, nullptr, EdgeState::clear, nullptr, [](const Point&) { return false; });
    EXPECT_EQ(cropped.from_u, EdgeState::clear);
    EXPECT_EQ(cropped.from_v, EdgeState::clear);
    EXPECT_TRUE(cropped.frees_v);
}

TEST_F(CropEdgeByTheBook, AContactFromUThatIsCutOffLeavesAClearEdge) {
    const Crossing u = touched(0.7, 0, true);
    const CroppedEdge cropped = crop(&u, nullptr);
    EXPECT_EQ(cropped.from_u, EdgeState::clear);
    EXPECT_EQ(cropped.from_v, EdgeState::clear);
    EXPECT_TRUE(cropped.frees_v);
    EXPECT_TRUE(cropped.on_segment_of_u);
}

TEST_F(CropEdgeByTheBook, AContactFromUThatIsNotCutOffStaysAndSaysNothingOfV) {
    const Crossing u = touched(0.3, 0, true);
    const CroppedEdge cropped = crop(&u, nullptr);
    EXPECT_EQ(cropped.from_u, EdgeState::crossing);
    EXPECT_EQ(cropped.from_v, EdgeState::unknown);
    EXPECT_FALSE(cropped.frees_v);
}

TEST_F(CropEdgeByTheBook, AContactFromWThatIsNotCutOffGoesToV) {
    const Crossing w = touched(0.3, 1, true);
    const CroppedEdge cropped = crop(nullptr, &w);
    EXPECT_EQ(cropped.from_u, EdgeState::unknown);
    EXPECT_EQ(cropped.from_v, EdgeState::crossing);
    EXPECT_TRUE(cropped.frees_v);
    EXPECT_FALSE(cropped.on_segment_of_u);
}

TEST_F(CropEdgeByTheBook, AContactFromWThatIsCutOffIsGone) {
    const Crossing w = touched(0.7, 1, true);
    const CroppedEdge cropped = crop(nullptr, &w);
    EXPECT_EQ(cropped.from_v, EdgeState::unknown);
    EXPECT_FALSE(cropped.frees_v);
}

TEST_F(CropEdgeByTheBook, AContactFromWithinFreesVOnlyIfItsSegmentCoversV) {
    const Crossing beyond = touched(0.2, 0.7, false);
    EXPECT_EQ(crop(nullptr, &beyond).from_v, EdgeState::crossing);
    EXPECT_TRUE(crop(nullptr, &beyond).frees_v);
    EXPECT_TRUE(crop(nullptr, &beyond).from_v_becomes_vertex);
    const Crossing before = touched(0.2, 0.4, false);
    EXPECT_EQ(crop(nullptr, &before).from_v, EdgeState::crossing);
    EXPECT_FALSE(crop(nullptr, &before).frees_v);
    EXPECT_FALSE(crop(nullptr, &before).from_v_becomes_vertex);
    const Crossing around = touched(0.8, 0.2, false);
    EXPECT_TRUE(crop(&around, nullptr).frees_v);
    EXPECT_EQ(crop(&around, nullptr).from_u, EdgeState::unknown);
    const Crossing cut = touched(0.8, 0.6, false);
    EXPECT_FALSE(crop(&cut, nullptr).frees_v);
}

}  // namespace
}  // namespace palpate::edge_record_test
