#include "planner/certificate.h"

#include <algorithm>
#include <sstream>

namespace palpate {
namespace {

using Kind = Premise::Kind;
using State = Premise::State;

template <typename... Parts>
std::string text(const Parts&... parts) {
    std::ostringstream out;
    (out << ... << parts);
    return out.str();
}

Premise manifold_premise(const Topology& t, const Evidence& evidence) {
    Premise premise{Kind::closed_oriented_manifold, State::checked,
                    text(t.facets, " facets, Euler characteristic ", t.euler_characteristic)};
    if (evidence.open_edges > 0 || evidence.given_up > 0 || !t.is_closed_oriented_manifold()) {
        premise.state = State::refuted;
        premise.detail =
            text(t.boundary_edges, " boundary, ", t.nonmanifold_edges, " non-manifold, ", t.inconsistent_edges,
                 " inconsistently oriented edges, ", t.split_vertices, " split vertices, ", t.inward_components, " inside-out components, ",
                 evidence.open_edges, " unexplored edges, ", evidence.given_up, " places given up");
    }
    return premise;
}

Premise component_premise(const Evidence& evidence) {
    Premise premise{Kind::every_component, State::assumed, {}};
    if (evidence.unrepresented_touches > 0) {
        premise.state = State::refuted;
        premise.detail =
            text(evidence.unrepresented_touches, " samples belong to no facet, although all that can be reached around them was probed");
    } else if (evidence.torn_components > 0) {
        premise.state = State::refuted;
        premise.detail = text(evidence.torn_components, " pairs of components of the mesh are near each other and may be one");
    } else if (evidence.seeds_given) {
        premise.detail = text("by the user: seed rays reach every component; the mesh has ", evidence.components);
    } else {
        premise.detail =
            text("by the user, who gave no seed rays: the object has no component besides the ", evidence.components, " in the mesh");
    }
    return premise;
}

Premise ball_premise(const Options& options, const Topology& t, const Evidence& evidence) {
    const bool good = t.facets > 0 && evidence.max_ball_radius <= options.epsilon;
    return {Kind::small_balls, good ? State::checked : State::refuted,
            text("largest ", evidence.max_ball_radius, " mm, epsilon ", options.epsilon, " mm")};
}

Premise reach_premise(const Options& options, const Evidence& evidence) {
    const double needed = options.epsilon / kMaxEpsilonPerReach;
    if (evidence.reach && evidence.reach->refuted) {
        return {Kind::reach, State::refuted,
                text("the given bound of ", *options.reach, " mm is false: ", evidence.reach->detail,
                     "; the largest bound that the touches allow is ", evidence.reach->largest, " mm; the mesh rests on ",
                     evidence.reach->is_local ? "local bounds" : text(evidence.reach->used, " mm"), ", and ", needed, " mm is needed")};
    }
    if (!options.reach) return {Kind::reach, State::missing, text("no reach bound given; a reach of at least ", needed, " mm would do")};
    if (*options.reach < needed) {
        return {Kind::reach, State::missing,
                text("the given bound of ", *options.reach, " mm is too small: this epsilon needs ", needed, " mm")};
    }
    return {Kind::reach, State::assumed, text("by the user: reach >= ", *options.reach, " mm; ", needed, " mm is needed")};
}

// Facets that no touch put into the mesh, and what they rest on.
Premise inference_premise(const Options& options, const ReachEvidence& reach) {
    Premise premise{Kind::inference, State::assumed, text(reach.inferred, " facets, with their balls, are inferred from ")};
    if (reach.is_local && !options.reach) {
        premise.state = State::missing;
        premise.detail += text("local bounds of at most ", reach.used, " mm, a heuristic that nobody vouches for");
    } else if (reach.is_local) {
        premise.detail += text("local bounds of at most ", reach.used, " mm, which the given bound implies");
        if (reach.refuted) premise.state = State::refuted;
    } else {
        premise.detail += reach.refuted ? "the lowered bound" : "the given bound";
    }
    premise.detail +=
        text("; ", reach.audited, " more were touched anyway, ", reach.audited_wrong, " of them not where they were inferred");
    return premise;
}

Premise touch_premise(const Evidence& evidence) {
    Premise premise{Kind::exact_touches, State::assumed, "by the user: their error is far below epsilon"};
    if (evidence.touch_error > 0)
        premise.detail = text("by the machine's configuration: their error is at most ", evidence.touch_error, " mm");
    if (evidence.grazes > 0) premise.detail += text("; ", evidence.grazes, " were taken back by a later probe of the same edge");
    if (evidence.failed_probes > 0)
        premise.detail += text("; ", evidence.failed_probes, " places could not be measured and are not in the mesh");
    return premise;
}

Premise facet_premise(const Evidence& evidence) {
    return {Kind::sizing_and_angles, evidence.bad_facets == 0 ? State::checked : State::refuted,
            text(evidence.bad_facets, " facets do not fulfil them, away from seed facets")};
}

// Of O itself, not of Ŝ: what S was seen to do between samples.
Premise thickness_premise(const Evidence& evidence) {
    if (evidence.unresolved_places > 0) {
        return {Kind::thickness, State::refuted,
                text("at ", evidence.unresolved_places, " places; the mesh does not have O's topology there")};
    }
    return {Kind::thickness, State::refuted,
            text("at ", evidence.minor_places, " places the mesh leaves out a sharp edge or a wall, less than epsilon of it")};
}

}  // namespace

const char* name_of(Premise::Kind kind) {
    switch (kind) {
        case Kind::closed_oriented_manifold:
            return "I1: closed oriented manifold";
        case Kind::every_component:
            return "I2: a vertex on every component";
        case Kind::small_balls:
            return "I3: every ball radius <= epsilon";
        case Kind::reach:
            return "epsilon <= 0.16 reach";
        case Kind::object_in_workspace:
            return "the workspace contains the object";
        case Kind::exact_touches:
            return "touches lie on the surface";
        case Kind::thickness:
            return "no wall thinner than samples show";
        case Kind::inference:
            return "inferred facets";
        case Kind::sizing_and_angles:
            return "sizing and angles";
        case Kind::own_end:
            return "the run ended by itself";
    }
    return "";
}

const Premise* Certificate::find(Premise::Kind kind) const {
    const auto found = std::ranges::find(premises, kind, &Premise::kind);
    return found == premises.end() ? nullptr : &*found;
}

Certificate certify(const Options& options, const Topology& topology, const Evidence& evidence) {
    Certificate certificate;
    const Premise manifold = manifold_premise(topology, evidence);
    const Premise components = component_premise(evidence);
    const Premise balls = ball_premise(options, topology, evidence);
    const Premise reach = reach_premise(options, evidence);
    certificate.premises = {
        manifold, components, balls, reach, {Kind::object_in_workspace, State::assumed, "by the user"}, touch_premise(evidence)};
    if (evidence.unresolved_places + evidence.minor_places > 0) certificate.premises.push_back(thickness_premise(evidence));
    if (evidence.reach) certificate.premises.push_back(inference_premise(options, *evidence.reach));
    if (evidence.has_facet_criteria) certificate.premises.push_back(facet_premise(evidence));
    const bool guesses = evidence.reach && evidence.reach->inferred > 0 && !certificate.find(Kind::inference)->holds();
    const bool is_shaped = !evidence.has_facet_criteria || certificate.find(Kind::sizing_and_angles)->holds();
    if (!evidence.stopped_by.empty()) {
        certificate.status = Certificate::Status::incomplete;
        certificate.premises.push_back({Kind::own_end, State::refuted, "the budget of " + evidence.stopped_by + " is used up"});
        certificate.statement =
            "Nothing is guaranteed: the run used up its budget of " + evidence.stopped_by + ". The mesh is what it knew then.";
        return certificate;
    }
    if (!is_shaped || !manifold.holds() || !components.holds() || !balls.holds() || evidence.unresolved_places > 0) {
        certificate.status = Certificate::Status::incomplete;
        certificate.statement = "Nothing is guaranteed: the run could not establish all that it has to establish.";
    } else if (reach.state == State::refuted) {
        const bool enough = !evidence.reach->is_local && evidence.reach->used * kMaxEpsilonPerReach >= options.epsilon;
        certificate.status = Certificate::Status::refuted;
        certificate.statement = text(
            "The given bound on the reach is false. The mesh is a closed oriented manifold whose surface Delaunay balls are at most "
            "epsilon; ",
            evidence.reach->is_local ? "its inferred facets rest on smaller local bounds, which do not guarantee the object's topology."
            : enough                 ? "it is isotopic to the object's surface if the lowered bound holds, which no touch contradicts."
                                     : "the lowered bound is too small for this epsilon to guarantee that it has the object's topology.");
    } else if (!reach.holds() || evidence.minor_places > 0) {
        certificate.status = Certificate::Status::conditional;
        certificate.statement = text(
            "The mesh is a closed oriented manifold whose surface Delaunay balls are at most epsilon; that it has the "
            "object's topology is not guaranteed, because ",
            reach.holds() ? "the object has sharp edges or walls that no reach allows" : "the premise on the reach is missing",
            ": gaps, holes and walls that are narrower than about epsilon may be missing, too.");
        if (evidence.minor_places > 0)
            certificate.statement += text(" At ", evidence.minor_places, " named places it ends before a sharp edge or a thin wall does.");
        if (guesses) certificate.statement += " Some of its facets are inferred by a heuristic.";
    } else {
        certificate.status = Certificate::Status::certified;
        certificate.statement =
            "As far as the assumed premises hold, the mesh is isotopic to the object's surface and at Fréchet distance "
            "O(epsilon²/reach) from it (Oudot 2005, section 1.2).";
    }
    return certificate;
}

}  // namespace palpate
