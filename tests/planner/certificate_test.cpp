#include "planner/certificate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace palpate::certificate_test {
namespace {

using Kind = Premise::Kind;
using State = Premise::State;
using Status = Certificate::Status;

struct Case {
    Options options;
    Topology topology;
    Evidence evidence;

    [[nodiscard]] Certificate certify() const { return palpate::certify(options, topology, evidence); }
};

Case good_case() {
    Case c;
    c.options.epsilon = 0.16;
    c.options.reach = 1.5;
    c.topology.vertices = 4;
    c.topology.edges = 6;
    c.topology.facets = 4;
    c.topology.components = 1;
    c.topology.euler_characteristic = 2;
    c.evidence.max_ball_radius = 0.15;
    c.evidence.components = 1;
    c.evidence.seeds_given = true;
    return c;
}

const Premise& premise(const Certificate& certificate, Kind kind) {
    const Premise* found = certificate.find(kind);
    EXPECT_NE(found, nullptr) << name_of(kind);
    static const Premise kNone;
    return found != nullptr ? *found : kNone;
}

bool promises_isotopy(const Certificate& certificate) {
    std::string all = certificate.statement;
    for (const Premise& p : certificate.premises) all += p.detail;
    return all.find("isotop") != std::string::npos || all.find("Fréchet") != std::string::npos ||
           all.find("homeomorph") != std::string::npos;
}

TEST(Certificate, CertifiedWhenEveryPremiseHolds) {
    const Certificate c = good_case().certify();
    EXPECT_EQ(c.status, Status::certified);
    EXPECT_TRUE(promises_isotopy(c));
    EXPECT_EQ(premise(c, Kind::closed_oriented_manifold).state, State::checked);
    EXPECT_EQ(premise(c, Kind::every_component).state, State::assumed);
    EXPECT_EQ(premise(c, Kind::small_balls).state, State::checked);
    EXPECT_EQ(premise(c, Kind::reach).state, State::assumed);
    EXPECT_EQ(premise(c, Kind::object_in_workspace).state, State::assumed);
    EXPECT_EQ(premise(c, Kind::exact_touches).state, State::assumed);
    for (const Premise& p : c.premises) {
        EXPECT_FALSE(p.detail.empty()) << name_of(p.kind);
        // planner/DESIGN.md, "Guarantees": who assumes it.
        if (p.state == State::assumed) {
            EXPECT_NE(p.detail.find("user"), std::string::npos) << name_of(p.kind);
        }
    }
}

TEST(Certificate, ConditionalWithoutAReachBoundAndSaysWhatWouldDo) {
    Case c = good_case();
    c.options.reach.reset();
    const Certificate certificate = c.certify();
    EXPECT_EQ(certificate.status, Status::conditional);
    EXPECT_EQ(premise(certificate, Kind::reach).state, State::missing);
    EXPECT_NE(premise(certificate, Kind::reach).detail.find("1 mm would do"), std::string::npos)
        << premise(certificate, Kind::reach).detail;
    EXPECT_FALSE(promises_isotopy(certificate));
    EXPECT_NE(certificate.statement.find("not guaranteed"), std::string::npos);
}

TEST(Certificate, ConditionalWhenTheReachBoundIsTooSmallForEpsilon) {
    Case c = good_case();
    c.options.reach = 0.999;
    EXPECT_EQ(c.certify().status, Status::conditional);
    EXPECT_EQ(premise(c.certify(), Kind::reach).state, State::missing);
    EXPECT_FALSE(promises_isotopy(c.certify()));
    c.options.reach = c.options.epsilon / kMaxEpsilonPerReach;
    EXPECT_EQ(c.certify().status, Status::certified) << "exactly at the limit";
}

TEST(Certificate, IncompleteAndNothingPromisedWhenI1Fails) {
    const std::vector<std::function<void(Case&)>> ways = {
        [](Case& c) {
            c.topology.defects.push_back({Defect::Kind::boundary_edge, {0, 1}, {0}}), c.topology.boundary_edges = 1;
        },
        [](Case& c) {
            c.topology.defects.push_back({Defect::Kind::nonmanifold_edge, {0, 1}, {0, 1, 2}}), c.topology.nonmanifold_edges = 1;
        },
        [](Case& c) {
            c.topology.defects.push_back({Defect::Kind::inconsistent_edge, {0, 1}, {0, 1}}), c.topology.inconsistent_edges = 1;
        },
        [](Case& c) {
            c.topology.defects.push_back({Defect::Kind::split_vertex, {0, 0}, {0, 1}}), c.topology.split_vertices = 1;
        },
        [](Case& c) { c.topology.inward_components = 1; },
        [](Case& c) { c.evidence.open_edges = 1; },
        [](Case& c) { c.topology = {}; },
    };
    for (std::size_t k = 0; k < ways.size(); ++k) {
        SCOPED_TRACE(k);
        Case c = good_case();
        ways[k](c);
        const Certificate certificate = c.certify();
        EXPECT_EQ(certificate.status, Status::incomplete);
        EXPECT_EQ(premise(certificate, Kind::closed_oriented_manifold).state, State::refuted);
        EXPECT_FALSE(promises_isotopy(certificate));
        EXPECT_NE(certificate.statement.find("Nothing is guaranteed"), std::string::npos);
    }
    Case c = good_case();
    ways[1](c);
    EXPECT_NE(premise(c.certify(), Kind::closed_oriented_manifold).detail.find("1 non-manifold"), std::string::npos)
        << "the evidence is named";
}

TEST(Certificate, IncompleteWhenATouchIsNotRepresented) {
    Case c = good_case();
    c.evidence.unrepresented_touches = 3;
    const Certificate certificate = c.certify();
    EXPECT_EQ(certificate.status, Status::incomplete);
    EXPECT_EQ(premise(certificate, Kind::every_component).state, State::refuted);
    EXPECT_NE(premise(certificate, Kind::every_component).detail.find("3 samples"), std::string::npos);
    EXPECT_FALSE(promises_isotopy(certificate));
}

TEST(Certificate, SaysWhetherTheUserGaveSeeds) {
    Case c = good_case();
    const std::string with = premise(c.certify(), Kind::every_component).detail;
    c.evidence.seeds_given = false;
    const std::string without = premise(c.certify(), Kind::every_component).detail;
    EXPECT_NE(with, without);
    EXPECT_NE(without.find("gave no seed rays"), std::string::npos) << without;
    EXPECT_EQ(c.certify().status, Status::certified) << "one component, as the user says by silence";
}

TEST(Certificate, IncompleteWhenABallIsTooLarge) {
    Case c = good_case();
    c.evidence.max_ball_radius = c.options.epsilon;
    EXPECT_EQ(premise(c.certify(), Kind::small_balls).state, State::checked) << "exactly at the limit";
    c.evidence.max_ball_radius = 0.1601;
    const Certificate certificate = c.certify();
    EXPECT_EQ(certificate.status, Status::incomplete);
    EXPECT_EQ(premise(certificate, Kind::small_balls).state, State::refuted);
    EXPECT_FALSE(promises_isotopy(certificate));
}

// planner/DESIGN.md, "Guarantees": never print a guarantee whose premise was not given. All combinations.
TEST(Certificate, PromisesIsotopyExactlyWhenCertified) {
    for (int mask = 0; mask < 64; ++mask) {
        Case c = good_case();
        if ((mask & 1) != 0) c.evidence.open_edges = 2;
        if ((mask & 2) != 0) c.evidence.unrepresented_touches = 2;
        if ((mask & 4) != 0) c.evidence.max_ball_radius = 1;
        if ((mask & 8) != 0) c.options.reach.reset();
        if ((mask & 16) != 0) c.options.reach = 0.1;
        if ((mask & 32) != 0) c.evidence.seeds_given = false;
        const Certificate certificate = c.certify();
        const Status expected = (mask & 7) != 0 ? Status::incomplete : (mask & 24) != 0 ? Status::conditional : Status::certified;
        EXPECT_EQ(certificate.status, expected) << mask;
        EXPECT_EQ(promises_isotopy(certificate), expected == Status::certified) << mask;
        const bool all_hold = std::all_of(certificate.premises.begin(), certificate.premises.end(),
                                          [](const Premise& p) { return p.state == State::checked || p.state == State::assumed; });
        EXPECT_EQ(all_hold, expected == Status::certified) << mask;
        EXPECT_FALSE(certificate.statement.empty());
    }
}

TEST(Certificate, NamesWhatInferredFacetsRestOn) {
    Case c = good_case();
    c.evidence.reach = ReachEvidence{};
    c.evidence.reach->used = 1.5;
    c.evidence.reach->inferred = 17;
    EXPECT_EQ(c.certify().status, Status::certified);
    EXPECT_EQ(premise(c.certify(), Kind::inference).state, State::assumed);
    EXPECT_NE(premise(c.certify(), Kind::inference).detail.find("17 facets"), std::string::npos);
    // What is plausible is not proven, whatever bound is given.
    c.evidence.reach->is_plausible = true;
    for (const std::optional<double> reach : {c.options.reach, std::optional<double>()}) {
        c.options.reach = reach;
        const Certificate guessed = c.certify();
        EXPECT_EQ(guessed.status, Status::conditional);
        EXPECT_EQ(premise(guessed, Kind::inference).state, State::missing);
        EXPECT_NE(guessed.statement.find("plausible only"), std::string::npos) << guessed.statement;
        EXPECT_FALSE(promises_isotopy(guessed));
    }
    // A given bound that touches contradict carries nothing.
    c.options.reach = 1.5;
    c.evidence.reach->is_plausible = false;
    c.evidence.reach->refuted = true;
    c.evidence.reach->largest = 1.2;
    const Certificate refuted = c.certify();
    EXPECT_EQ(refuted.status, Status::refuted);
    EXPECT_NE(premise(refuted, Kind::inference).detail.find("the lowered bound"), std::string::npos);
    EXPECT_NE(premise(refuted, Kind::reach).detail.find("1.2 mm"), std::string::npos);
}

// The bounds are those of Clopper and Pearson, as tables have them.
TEST(Certificate, SaysHowManyPlausibleFacetsMayBeWrong) {
    Case c = good_case();
    c.evidence.reach = ReachEvidence{};
    c.evidence.reach->is_plausible = true;
    const auto detail = [&](std::uint64_t wrong, std::uint64_t of) {
        c.evidence.reach->audited = of;
        c.evidence.reach->audited_wrong = wrong;
        return premise(c.certify(), Kind::inference).detail;
    };
    EXPECT_NE(detail(0, 300).find("at most 1.00 % are wrong, of those that a touch can reach"), std::string::npos) << detail(0, 300);
    EXPECT_NE(detail(3, 100).find("at most 7.6 % are wrong"), std::string::npos) << detail(3, 100);
    EXPECT_NE(detail(0, 10).find("at most 26 % are wrong"), std::string::npos) << detail(0, 10);
    EXPECT_NE(detail(10, 10).find("at most 100 % are wrong"), std::string::npos) << detail(10, 10);
    EXPECT_NE(detail(0, 0).find("at most 100 % are wrong"), std::string::npos) << detail(0, 0);
}

TEST(Certificate, NothingIsGuaranteedAfterABudgetOrWithBadFacets) {
    Case c = good_case();
    c.evidence.stopped_by = "99 probes";
    EXPECT_EQ(c.certify().status, Status::incomplete);
    EXPECT_NE(c.certify().statement.find("budget of 99 probes ended the run"), std::string::npos);
    EXPECT_FALSE(promises_isotopy(c.certify()));
    // What it left is not what a run to its end would show.
    c.evidence.unrepresented_touches = 7;
    c.evidence.unresolved_places = 2;
    c.evidence.minor_places = 1;
    EXPECT_EQ(c.certify().status, Status::incomplete);
    for (const auto& [kind, count] : {std::pair{Kind::every_component, "7 samples"}, std::pair{Kind::thickness, "3 places"}}) {
        const Premise p = premise(c.certify(), kind);
        EXPECT_EQ(p.state, State::missing);
        EXPECT_NE(p.detail.find(count), std::string::npos) << p.detail;
        EXPECT_NE(p.detail.find("a budget ended the run"), std::string::npos) << p.detail;
        EXPECT_EQ(p.detail.find("can be reached"), std::string::npos) << p.detail;
    }
    c = good_case();
    c.evidence.has_facet_criteria = true;
    EXPECT_EQ(c.certify().status, Status::certified);
    EXPECT_EQ(premise(c.certify(), Kind::sizing_and_angles).state, State::checked);
    c.evidence.bad_facets = 3;
    EXPECT_EQ(c.certify().status, Status::incomplete);
    EXPECT_EQ(premise(c.certify(), Kind::sizing_and_angles).state, State::refuted);
}

}  // namespace
}  // namespace palpate::certificate_test
