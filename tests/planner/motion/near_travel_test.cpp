#include "planner/motion/near_travel.h"

#include <gtest/gtest.h>

#include <memory>
#include <set>

#include "planner/inference/inference.h"
#include "planner/plausibility/plausibility.h"
#include "tests/planner/loop/growing.h"

namespace palpate::near_travel_test {
namespace {

constexpr std::uint64_t kSeed = 20261201;
// A way over the roadmap that is longer than the straight one by that factor is not worth its length (near_travel.cc).
constexpr double kDetour = 4.0;

// mm: of the shortest way outside the unit sphere.
double shortest_around_sphere(const Point& p, const Point& q) {
    if (distance_to({p, q}, Point::Zero()) >= 1) return (q - p).norm();
    const double angle = std::atan2(p.cross(q).norm(), p.dot(q));
    const auto tangent = [](const Point& x) { return std::sqrt(std::max(0.0, x.squaredNorm() - 1)); };
    return tangent(p) + tangent(q) + angle - std::atan(tangent(p)) - std::atan(tangent(q));
}

// A surface that is grown all over, with the tool somewhere near it.
class NearSurface {
public:
    // Without a reach, space is free as far as that is plausible.
    NearSurface(const Torus& torus, double epsilon, std::optional<double> reach, std::uint64_t seed)
        : random(seed),
          epsilon_(epsilon),
          growing_(torus, epsilon),
          model_(reach ? std::unique_ptr<SurfaceModel>(std::make_unique<Inference>(state(), *reach, 4 * epsilon, seeded().rounding()))
                       : std::make_unique<Plausibility>(state(), epsilon, seeded().rounding())),
          travel_(seeded().space, head(), *model_, epsilon, 0) {
        growing_.run();
        for (const Touch& touch : head().touches()) {
            if (touch.sample) model_->note_sample(*touch.sample, touch.from - touch.position);
        }
    }

    [[nodiscard]] Seeded& seeded() { return growing_.seeded(); }
    [[nodiscard]] MaintainedDelaunay& state() { return growing_.state(); }
    [[nodiscard]] ProbeHead& head() { return seeded().head; }
    [[nodiscard]] Roadmap& roadmap() { return seeded().space.roadmap(); }
    [[nodiscard]] const Torus& torus() { return seeded().torus; }
    [[nodiscard]] NearTravel& travel() { return travel_; }
    [[nodiscard]] double epsilon() const { return epsilon_; }
    [[nodiscard]] std::uint32_t random_sample() { return static_cast<std::uint32_t>(random.below(state().sample_count())); }

    // A place in some sample's clearance, outside the solid.
    [[nodiscard]] HoverPlace random_place() {
        while (true) {
            const std::uint32_t s = random_sample();
            if (!model_->has_clearance(s)) continue;
            const Point p = state().sample(s) + random.uniform(0.02, 2) * epsilon_ * model_->normal(s) +
                            random.uniform(0, epsilon_) * random.direction();
            const bool is_good =
                model_->clearance(s).contains(p) && torus().distance(p) > 0.01 * epsilon_ && seeded().workspace.contains(p);
            if (is_good) return {p, s};
        }
    }

    // Where the tool is, by all accounts; if `met`, on the surface.
    void expect_at(const std::optional<NearTravel::Met>& met, const Point& goal) {
        const Point& at = roadmap().at(head().at());
        const Point expected = met ? met->position : goal;
        ASSERT_LE((seeded().oracle.position() - expected).norm(), seeded().rounding());
        ASSERT_LE((at - expected).norm(), seeded().rounding());
        if (met) {
            ASSERT_TRUE(met->is_contact());
            ASSERT_NEAR(torus().distance(met->position), 0, seeded().rounding()) << "a touch of nothing";
            ASSERT_EQ(head().contact().at, head().at());
            ASSERT_EQ(head().touches().at(met->touch).position, met->position);
            contacts_.insert(head().at());
        }
        seeded().expect_safe_moves();
        seeded().expect_true_account();
    }
    // No way leads through a place on S.
    void expect_dead_ends() {
        std::set<std::array<double, 3>> places;
        for (const NodeId contact : contacts_) {
            const Point& p = roadmap().at(contact);
            places.insert({p.x(), p.y(), p.z()});
            EXPECT_EQ(roadmap().neighbors(contact).size(), 1U);
        }
        for (int k = 0; k < 200; ++k) {
            const auto from = static_cast<NodeId>(random.below(roadmap().size()));
            const auto to = static_cast<NodeId>(random.below(roadmap().size()));
            const std::vector<Point> points = roadmap().short_path(from, to).points;
            for (std::size_t i = 0; i + 1 < points.size(); ++i) {
                EXPECT_FALSE(places.contains({points[i].x(), points[i].y(), points[i].z()}));
            }
        }
        EXPECT_TRUE(roadmap().is_valid());
    }
    [[nodiscard]] std::size_t contacts() const { return contacts_.size(); }
    [[nodiscard]] double displacement() { return seeded().oracle.travel_length + seeded().oracle.probing_length; }

    Random random;

private:
    const double epsilon_;
    Growing growing_;
    std::unique_ptr<SurfaceModel> model_;
    NearTravel travel_;
    std::set<NodeId> contacts_;
};

TEST(NearTravel, EveryWayEndsAtItsGoalOrAtATouch) {
    const Torus sphere = Torus::sphere(1);
    const Torus torus{1, 0.4};
    // The last takes balls to be free that are not, in the hole and across it.
    for (const auto& [surface, reach] : {std::pair{sphere, std::optional(1.0)}, {torus, std::optional(0.4)}, {torus, std::nullopt}}) {
        SCOPED_TRACE(seed_text(kSeed) + (reach ? "" : ", plausible"));
        NearSurface near(surface, surface.is_sphere() ? 0.2 : 0.18, reach, kSeed);
        int touched_on_the_way = 0;
        for (int k = 0; k < 150; ++k) {
            const HoverPlace goal = near.random_place();
            const bool was_at_contact = near.head().at() == near.head().contact().at;
            const NodeId contact = near.head().contact().at;
            const std::size_t travels = near.seeded().oracle.travels.size();
            const auto met = near.travel().go_to(goal);
            near.expect_at(met, goal.point);
            if (HasFatalFailure()) return;
            if (met) {
                ++touched_on_the_way;
                ASSERT_TRUE(!reach || !met->on_free_way) << "a lens of a true bound";
            }
            if (was_at_contact) {
                // First back, straight, the way it came.
                ASSERT_GT(near.seeded().oracle.travels.size(), travels);
                const Segment& lift = near.seeded().oracle.travels[travels];
                ASSERT_EQ(lift.source, near.roadmap().at(contact));
                ASSERT_GT(near.torus().distance(lift.target), 0);
            }
            if (met || near.random.chance(0.3)) continue;
            // Down to the surface.
            const Point target = near.torus().nearest(goal.point).point - 0.1 * near.epsilon() * near.torus().nearest(goal.point).normal;
            const auto touched = near.travel().probe(target, true);
            ASSERT_TRUE(touched);
            near.expect_at(touched, target);
            if (HasFatalFailure()) return;
            if (near.random.chance(0.1)) near.travel().forget_all();
        }
        EXPECT_GT(near.contacts(), 60U);
        EXPECT_TRUE(reach || touched_on_the_way > 10) << "nothing was wrong";
        near.expect_dead_ends();
    }
}

TEST(NearTravel, WaysThroughLensesAreNotMuchLongerThanTheShortest) {
    SCOPED_TRACE(seed_text(kSeed + 1));
    NearSurface near(Torus::sphere(1), 0.2, 1.0, kSeed + 1);
    ASSERT_FALSE(near.travel().go_to(near.random_place()));
    double total = 0;
    double least = 0;
    for (int k = 0; k < 150; ++k) {
        const HoverPlace goal = near.random_place();
        const Point from = near.seeded().oracle.position();
        const double before = near.displacement();
        const auto met = near.travel().go_to(goal);
        ASSERT_FALSE(met) << "lenses are all over the sphere";
        near.expect_at(met, goal.point);
        if (HasFatalFailure()) return;
        const double length = near.displacement() - before;
        const double shortest = shortest_around_sphere(from, goal.point);
        ASSERT_GE(length, shortest - 1e-9) << "shorter than is possible";
        EXPECT_LE(length, kDetour * shortest + 2 * near.epsilon());
        total += length;
        least += shortest;
    }
    EXPECT_LT(total, 1.25 * least);
}

TEST(NearTravel, AnApproachIsNoLongerThanTheRoadmapAndEndsAtItsNodeOrATouch) {
    SCOPED_TRACE(seed_text(kSeed + 2));
    NearSurface near(Torus::sphere(1), 0.2, 1.0, kSeed + 2);
    int shorter = 0;
    double saved = 0;
    for (int k = 0; k < 150; ++k) {
        const HoverPlace away = near.random_place();
        const auto met_away = near.travel().go_to(away);
        near.expect_at(met_away, away.point);
        const std::uint32_t s = near.random_sample();
        const NodeId goal = near.head().start_of_sample(s);
        std::vector<std::uint32_t> around;
        near.state().adjacent_samples(s, around);
        const std::array<std::uint32_t, 3> samples{s, around[0], around[1]};
        const double before = near.displacement();
        const double by_roadmap = near.roadmap().short_path(near.head().at(), goal).length;
        const auto met = near.travel().approach(goal, samples, false);
        near.expect_at(met, near.roadmap().at(near.head().at()));
        if (HasFatalFailure()) return;
        if (met) continue;
        const double length = near.displacement() - before + near.roadmap().short_path(near.head().at(), goal).length;
        EXPECT_LE(length, by_roadmap + 0.1 * near.epsilon());
        shorter += length < 0.5 * by_roadmap;
        saved += by_roadmap - length;
    }
    EXPECT_GT(shorter, 15);
    EXPECT_GT(saved, 0);
    near.expect_dead_ends();
}

}  // namespace
}  // namespace palpate::near_travel_test
