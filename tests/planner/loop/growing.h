// A torus or sphere in closed form on which Ŝ grows as in a run, but without the walks; and what every step of that must not break.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "planner/delaunay/restricted_surface.h"
#include "planner/loop/seeding.h"
#include "planner/loop/surface_growth.h"
#include "planner/topology.h"
#include "tests/planner/support.h"
#include "tests/planner/torus.h"

namespace palpate {

// A surface that has its seed facet.
struct Seeded {
    Torus torus;
    Region workspace;
    SolidOracle oracle;
    ProbedSpace space;
    MaintainedDelaunay& state = space.delaunay();
    ProbeHead head;
    Options options;

    Seeded(const Torus& t, double epsilon)
        : torus(t),
          workspace(Ball{Point::Zero(), 1.5 * (t.major + t.minor)}),
          oracle([t](const Point& from, const Point& to) { return t.first_hit(from, to); }, 2 * workspace.radius() * Vector::UnitZ()),
          space(workspace),
          head(oracle, workspace, space.roadmap()) {
        options.epsilon = epsilon;
        options.reach = t.reach();
        options.audit = 0;
        // Beside the hole.
        const Torus::Place top = t.at(0.3, std::numbers::pi / 2 - 0.2);
        options.seed_rays = {{top.point + 3 * workspace.radius() * Vector::UnitZ(), top.point - Vector::UnitZ()}};
        EXPECT_EQ(touch_seeds(options, space, head).size(), 1U);
    }

    [[nodiscard]] double rounding() const { return 1e-9 * workspace.radius(); }
    [[nodiscard]] Topology topology() const { return analyse_topology(extract_surface(state).mesh); }

    // What the tool did since it was looked at last: unguarded moves are on ground that is known, and none enters the solid.
    void expect_safe_moves() {
        for (; travels_seen_ < oracle.travels.size(); ++travels_seen_) {
            const Segment& way = oracle.travels[travels_seen_];
            ASSERT_TRUE(is_known(way)) << "travelled through the object, or over ground that nothing shows to be free";
        }
        for (; probes_seen_ < oracle.probes.size(); ++probes_seen_) {
            const Segment& way = oracle.probes[probes_seen_];
            ASSERT_TRUE(is_outside_object(way)) << "a probe began inside the object";
        }
    }
    // The account is that of the oracle, the tool where the planner takes it to be.
    void expect_true_account() const {
        const Cost& cost = head.cost();
        ASSERT_EQ(cost.contact, oracle.contacts);
        ASSERT_EQ(head.touches().size(), oracle.contacts);
        ASSERT_LE(cost.probes(), oracle.probes.size()) << "moves through lenses that meet nothing are travel";
        const double length = oracle.travel_length + oracle.probing_length;
        ASSERT_NEAR(cost.displacement(), length, 1e-9 * length);
        ASSERT_LE((space.roadmap().at(head.at()) - oracle.position()).norm(), rounding());
    }

private:
    [[nodiscard]] bool is_outside_object(const Segment& way) const {
        return torus.least_distance(way.source, way.target, rounding()) > -2 * rounding();
    }
    // Outside ω, or a part of what was probed.
    [[nodiscard]] bool is_known(const Segment& way) {
        const auto [known, is_new] =
            known_.try_emplace({way.source.x(), way.source.y(), way.source.z(), way.target.x(), way.target.y(), way.target.z()});
        if (is_new) known->second = is_outside_object(way) && (was_probed(way) || is_outside_region(way));
        return known->second;
    }
    [[nodiscard]] bool was_probed(const Segment& way) const {
        const auto lies_on = [&](const Segment& s) {
            return distance_to(s, way.source) <= rounding() && distance_to(s, way.target) <= rounding();
        };
        return std::any_of(oracle.probes.rbegin(), oracle.probes.rend(), lies_on);
    }
    [[nodiscard]] bool is_outside_region(const Segment& way) const {
        for (int k = 0; k <= 32; ++k) {
            if (depth(workspace, way.source + k / 32.0 * (way.target - way.source)) > rounding()) return false;
        }
        return true;
    }

    std::map<std::array<double, 6>, bool> known_;  // by its ends
    std::size_t travels_seen_ = 0;
    std::size_t probes_seen_ = 0;
};

class Growing {
public:
    // `choose` may change the options before growth begins.
    Growing(const Torus& torus, double epsilon, const std::function<void(Options&)>& choose = {})
        : seeded_(torus, epsilon), effort_(epsilon) {
        if (choose) choose(seeded_.options);
        criteria_.emplace(seeded_.options);
        observer_.on_inference = [this](const Point& near, const Point& far) { inferred.push_back({near, far}); };
        growth_.emplace(seeded_.space, seeded_.head, seeded_.options, OracleTraits{}, *criteria_, observer_, effort_);
    }

    [[nodiscard]] Seeded& seeded() { return seeded_; }
    [[nodiscard]] SurfaceGrowth& growth() { return *growth_; }
    [[nodiscard]] MaintainedDelaunay& state() { return seeded_.state; }

    // As ProbingLoop does. `see` hears of every refutation that was settled, and how much was inferred before. False if nothing is left to
    // do.
    bool step(const std::function<void(std::size_t)>& see = {}) {
        const auto step = growth_->step();
        if (step) insert(*step);
        bool refuted = false;
        for (std::size_t before = inferred.size(); growth_->settle_refutation(); before = inferred.size()) {
            refuted = true;
            if (see) see(before);
        }
        return step.has_value() || refuted;
    }
    void insert(const SurfaceGrowth::Step& step) {
        if (!step.sample) return;
        const MaintainedDelaunay::Insertion insertion = seeded_.space.insert(step.sample->position, step.sample->near);
        seeded_.head.assign(step.sample->touch, Touch::Role::refinement, insertion.sample);
        effort_.note_sample(step.sample->position);
        growth_->note_insertion(insertion, seeded_.head.touches()[step.sample->touch]);
    }
    // To the end, which comes.
    void run() {
        for (int steps = 0; step(); ++steps) ASSERT_LT(steps, 20'000);
    }

    template <typename Visit>
    void for_each_inferred(const Visit& visit) {
        state().for_each_edge([&](DirectedEdge e) {
            if (state().recorded_state(e) == EdgeState::crossing && state().crossing(e).inferred) visit(e);
        });
    }

    std::vector<Segment> inferred;  // all that was inferred so far: the gaps

private:
    Seeded seeded_;
    Effort effort_;
    Observer observer_;
    std::optional<Criteria> criteria_;
    std::optional<SurfaceGrowth> growth_;
};

}  // namespace palpate
