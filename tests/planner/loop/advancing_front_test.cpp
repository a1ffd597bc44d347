#include "planner/loop/advancing_front.h"

#include <gtest/gtest.h>

#include <map>
#include <numbers>
#include <tuple>

#include "planner/inference/inference.h"
#include "planner/probe_surface.h"
#include "tests/planner/loop/growing.h"

namespace palpate::advancing_front_test {
namespace {

// Touches for one open edge (advancing_front.cc), and the one after which it is given up.
constexpr int kMostAttempts = 4;

std::array<double, 6> key(const FrontTouch& t) { return {t.start.x(), t.start.y(), t.start.z(), t.target.x(), t.target.y(), t.target.z()}; }

// Plays the loop around a front: answers its touches in closed form and learns from them as SurfaceGrowth does, without a tool.
class Playing {
public:
    Playing(const Torus& torus, double epsilon)
        : epsilon_(epsilon),
          seeded_(torus, epsilon),
          inference_(state(), torus.reach(), 4 * epsilon, seeded_.rounding()),
          front_(state(), inference_, {epsilon, epsilon}) {
        for (const Touch& touch : seeded_.head.touches()) {
            if (touch.sample) inference_.note_sample(*touch.sample, touch.from - touch.position);
        }
        front_.sweep();
    }

    [[nodiscard]] MaintainedDelaunay& state() { return seeded_.state; }
    [[nodiscard]] Seeded& seeded() { return seeded_; }
    [[nodiscard]] const Torus& torus() const { return seeded_.torus; }
    [[nodiscard]] AdvancingFront& front() { return front_; }
    [[nodiscard]] int asked() const { return asked_; }
    [[nodiscard]] int certain_samples() const { return certain_samples_; }
    [[nodiscard]] int audits() const { return audits_; }
    [[nodiscard]] const std::map<std::array<std::uint32_t, 3>, int>& asked_of_facets() const { return asked_of_facets_; }

    // One touch, with the laws of it; false if the front asks for nothing more. `silent`: nothing comes of it.
    bool step(bool silent = false) {
        const auto touch = front_.next(head_);
        EXPECT_FALSE(inference_.is_refuted());
        if (!touch || testing::Test::HasFatalFailure()) return false;
        ++asked_;
        expect_lawful(*touch);
        if (silent) {
            if (touch->along) front_.note_missed(touch->along->corners);
        } else if (!testing::Test::HasFatalFailure()) {
            answer(*touch);
        }
        return !testing::Test::HasFatalFailure() && asked_ < 20'000;
    }

private:
    void expect_lawful(const FrontTouch& touch) {
        ASSERT_TRUE(inference_.has_clearance(touch.home));
        ASSERT_TRUE(inference_.clearance(touch.home).contains(touch.start)) << "the start is not known to be free";
        ASSERT_GT(torus().distance(touch.start), 0);
        ASSERT_TRUE(seeded_.workspace.contains(touch.start));
        ASSERT_LT(touch.interior_of, state().sample_count());
        const auto& [a, b, c] = touch.beside;
        ASSERT_TRUE(a != b && b != c && c != a);
        for (const std::uint32_t s : touch.beside) {
            ASSERT_LT(s, state().sample_count());
            ASSERT_LE((state().sample(s) - touch.start).norm(), 4 * epsilon_);
        }
        ASSERT_LE(++asked_of_places_[key(touch)], kMostAttempts) << "asked again and again";
        if (touch.certain) {
            ASSERT_LE(torus().distance(touch.target), seeded_.rounding()) << "the target is not inside";
            ASSERT_TRUE(torus().first_hit(touch.start, touch.target)) << "the surface does not lie before the target";
        }
        if (touch.along) {
            expect_lawful_edge(touch);
        } else {
            ASSERT_FALSE(touch.audit);
            ASSERT_EQ(state().count_facets_at(a, b, {}).in_surface, 1) << "not an open edge";
            ASSERT_FALSE(front_.is_thin(a) || front_.is_thin(b));
        }
        ASSERT_TRUE(!touch.under || seeded_.workspace.contains(*touch.under));
    }
    void expect_lawful_edge(const FrontTouch& touch) {
        const FacetView& view = *touch.along;
        ASSERT_EQ(touch.beside, view.corners);
        ASSERT_TRUE(state().find_facet(view.corners[0], view.corners[1], view.corners[2]));
        for (const Point& p : {touch.start, touch.target}) {
            const double height = view.up.dot(p - view.line.origin);
            ASSERT_LE((view.at(height) - p).norm(), seeded_.rounding()) << "beside the dual edge";
        }
        ASSERT_GT(view.up.dot(touch.start - touch.target), 0);
        ASSERT_EQ(touch.audit, state().inferred(view.inwards).has_value());
        ASSERT_TRUE(touch.audit || !state().crossed(view.inwards)) << "what is known";
        audits_ += touch.audit;
        if (!touch.audit) ++asked_of_facets_[in_order(view.corners)];
    }

    void answer(const FrontTouch& touch) {
        Point from = touch.start;
        auto hit = torus().first_hit(from, touch.target);
        if (!hit && touch.under && torus().distance(touch.target) > 0) {
            from = touch.target;
            hit = torus().first_hit(from, *touch.under);
        }
        if (!hit) {
            head_ = touch.target;
            if (touch.along) front_.note_missed(touch.along->corners);
            return;
        }
        head_ = *hit;
        const std::array<std::uint32_t, 5> lenses{touch.home, touch.interior_of, touch.beside[0], touch.beside[1], touch.beside[2]};
        inference_.check(*hit, true, lenses);
        if (touch.along) learn_crossing(*touch.along, from, *hit, touch.audit);
        double nearest = std::numeric_limits<double>::infinity();
        for (const Point& p : state().samples()) nearest = std::min(nearest, (p - *hit).norm());
        if (nearest > epsilon_) {
            const auto insertion = state().insert(*hit, state().cell_at(touch.beside[0]));
            inference_.note_sample(insertion.sample, from - *hit);
            front_.note_insertion(insertion);
        } else {
            ASSERT_TRUE(touch.along || !touch.certain) << "a new sample was announced, and its place was taken";
            inference_.note_touch(*hit, from - *hit, touch.beside);
        }
        certain_samples_ += touch.certain && !touch.along;
    }
    void learn_crossing(const FacetView& along, const Point& from, const Point& hit, bool audit) {
        const double height = along.up.dot(hit - along.line.origin);
        if (height < along.bottom || height > along.top) return front_.note_missed(along.corners);
        if ((hit - state().sample(along.corners[0])).norm() > epsilon_) return;
        if (const auto inferred = state().inferred(along.inwards)) {
            ASSERT_TRUE(audit);
            const Crossing& gap = state().crossing(*inferred);
            ASSERT_LE(height, along.up.dot(gap.near - along.line.origin) + seeded_.rounding());
            ASSERT_GE(height, along.up.dot(gap.far - along.line.origin) - seeded_.rounding());
            state().withdraw(*inferred);
        }
        if (state().recorded_state(along.inwards) != EdgeState::unknown) return;
        Crossing seen;
        seen.near = hit;
        seen.from = along.up.dot(from - along.line.origin) > along.top ? along.at(along.top) : from;
        seen.from_vertex = false;
        state().learn_contact(along.inwards, seen);
        front_.note_edges(along.inwards);
    }

    const double epsilon_;
    Seeded seeded_;
    Inference inference_;
    AdvancingFront front_;
    Point head_ = Point::Zero();
    int asked_ = 0;
    int audits_ = 0;
    int certain_samples_ = 0;
    std::map<std::array<double, 6>, int> asked_of_places_;
    std::map<std::array<std::uint32_t, 3>, int> asked_of_facets_;  // in doubt
};

// Edges with one facet of Ŝ.
std::size_t count_open_edges(Playing& playing) { return playing.seeded().topology().boundary_edges; }

TEST(AdvancingFront, ClosesTheSurfaceWithFewTouchesThatKeepItsLaws) {
    for (const auto& [torus, epsilon, most] :
         {std::tuple{Torus::sphere(1), 0.2, 1.15}, {Torus::sphere(1), 0.12, 1.1}, {Torus{1, 0.4}, 0.1, 1.25}}) {
        SCOPED_TRACE("epsilon " + std::to_string(epsilon));
        Playing playing(torus, epsilon);
        EXPECT_GT(count_open_edges(playing), 0U);
        while (playing.step()) {
        }
        if (HasFatalFailure()) return;
        EXPECT_EQ(playing.front().open_count(), 0U);
        const RestrictedSurface surface = extract_surface(playing.state());
        const Topology topology = analyse_topology(surface.mesh);
        EXPECT_TRUE(topology.is_closed_oriented_manifold());
        EXPECT_EQ(topology.euler_characteristic, torus.euler_characteristic());
        for (const double radius : surface.ball_radii) EXPECT_LE(radius, epsilon);
        const auto samples = static_cast<double>(playing.state().sample_count());
        EXPECT_LT(samples, 1.6 * lower_bound_samples(torus.area(), epsilon));
        EXPECT_GT(playing.certain_samples(), 0.9 * samples) << "lenses announce most samples";
        EXPECT_LT(playing.asked(), most * samples) << "lenses overlap less where the reach is few epsilon";
    }
}

TEST(AdvancingFront, WhatIsNeverAnsweredIsGivenUp) {
    Playing playing(Torus::sphere(1), 0.2);
    for (int k = 0; k < 40; ++k) ASSERT_TRUE(playing.step());
    const std::size_t open = count_open_edges(playing);
    const int before = playing.asked();
    while (playing.step(true)) {
    }
    EXPECT_GT(playing.asked(), before);
    EXPECT_LE(static_cast<std::size_t>(playing.asked() - before), kMostAttempts * open);
    EXPECT_EQ(count_open_edges(playing), open) << "they are left to the walks";
    for (const auto& [facet, times] : playing.asked_of_facets()) EXPECT_EQ(times, 1) << "a touch that taught nothing was repeated";
    playing.front().sweep();
    EXPECT_FALSE(playing.step()) << "and for good";
}

TEST(AdvancingFront, AuditsWhatItIsAskedTo) {
    Playing playing(Torus::sphere(1), 0.15);
    while (playing.step()) {
    }
    if (HasFatalFailure()) return;
    EXPECT_EQ(playing.audits(), 0);
    int asked = 0;
    for (const DirectedEdge e : extract_surface(playing.state()).dual_edges) {
        if (playing.state().crossing(e).inferred && ++asked % 3 == 0) playing.front().note_audit(e);
    }
    ASSERT_GT(asked, 100);
    while (playing.step()) {
    }
    EXPECT_EQ(playing.audits(), asked / 3) << "all can be reached";
}

TEST(AdvancingFront, KeepsAwayFromThinPlaces) {
    Playing playing(Torus::sphere(1), 0.2);
    for (int k = 0; k < 60; ++k) ASSERT_TRUE(playing.step());
    // That no open edge of those is asked for is among the laws of every step.
    for (std::uint32_t s = 0; s < playing.state().sample_count(); s += 5) playing.front().note_thin(s);
    for (int k = 0; k < 20; ++k) ASSERT_TRUE(playing.step());
    for (std::uint32_t s = 0; s < playing.state().sample_count(); ++s) playing.front().note_thin(s);
    EXPECT_GT(count_open_edges(playing), 0U);
    EXPECT_FALSE(playing.step());
}

TEST(AdvancingFront, TheSameAnswersGiveTheSameTouches) {
    const auto samples = [] {
        Playing playing(Torus{1, 0.4}, 0.12);
        while (playing.step()) {
        }
        return std::vector<Point>(playing.state().samples().begin(), playing.state().samples().end());
    };
    const std::vector<Point> once = samples();
    EXPECT_GT(once.size(), 400U);
    EXPECT_EQ(samples(), once);
}

}  // namespace
}  // namespace palpate::advancing_front_test
