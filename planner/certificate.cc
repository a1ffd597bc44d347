#include "planner/certificate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

using Kind = Premise::Kind;
using State = Premise::State;

Premise manifold_premise(const Topology& t, const Evidence& evidence) {
    Premise premise{Kind::closed_oriented_manifold, State::checked,
                    fmt::format("{} facets, Euler characteristic {}", t.facets, t.euler_characteristic)};
    if (evidence.open_edges > 0 || evidence.given_up > 0 || !t.is_closed_oriented_manifold()) {
        premise.state = State::refuted;
        premise.detail = fmt::format(
            "{} boundary, {} non-manifold, {} inconsistently oriented edges, {} split vertices, {} inside-out components, {} unexplored "
            "edges, {} places given up",
            t.boundary_edges, t.nonmanifold_edges, t.inconsistent_edges, t.split_vertices, t.inward_components, evidence.open_edges,
            evidence.given_up);
    }
    return premise;
}

Premise component_premise(const Evidence& evidence) {
    Premise premise{Kind::every_component, State::assumed, {}};
    if (evidence.unrepresented_touches > 0 && !evidence.stopped_by.empty()) {
        premise.state = State::missing;
        premise.detail = fmt::format("{} samples belong to no facet yet: a budget ended the run before all around them was probed",
                                     evidence.unrepresented_touches);
    } else if (evidence.unrepresented_touches > 0) {
        premise.state = State::refuted;
        premise.detail = fmt::format("{} samples belong to no facet, although all that can be reached around them was probed",
                                     evidence.unrepresented_touches);
    } else if (evidence.torn_components > 0) {
        premise.state = State::refuted;
        premise.detail = fmt::format("{} pairs of components of the mesh are near each other and may be one", evidence.torn_components);
    } else if (evidence.earlier) {
        premise.detail = fmt::format("by the user: the earlier run touched every component; the mesh has {}", evidence.components);
    } else if (evidence.seeds_given) {
        premise.detail = fmt::format("by the user: seed rays reach every component; the mesh has {}", evidence.components);
    } else {
        premise.detail =
            fmt::format("by the user, who gave no seed rays: the object has no component besides the {} in the mesh", evidence.components);
    }
    return premise;
}

Premise ball_premise(const Options& options, const Topology& t, const Evidence& evidence) {
    const double largest = std::max(evidence.max_ball_radius, evidence.max_plausible_ball_radius);
    const bool good = t.facets > 0 && largest <= options.epsilon;
    std::string detail = fmt::format("largest {:.6g} mm, epsilon {:.6g} mm", evidence.max_ball_radius, options.epsilon);
    if (evidence.max_plausible_ball_radius > 0)
        detail += fmt::format("; {:.6g} mm as far as plausible facets are right", evidence.max_plausible_ball_radius);
    return {Kind::small_balls, good ? State::checked : State::refuted, std::move(detail)};
}

Premise known_solids_premise(const Evidence& evidence) {
    return {Kind::known_solids, State::assumed,
            fmt::format("by the user: fixtures are where they are said to be{}; {} samples lie on them, untouched",
                        evidence.assumes_clear ? ", and nothing but the object stands on them" : "",
                        evidence.known_samples - evidence.wall_samples)};
}

Premise area_premise(const Evidence& evidence) {
    return {
        Kind::within_area, State::assumed,
        fmt::format("by the user: what is to be known lies within the area{}, and what stands outside does not meet the tool's holder; {} "
                    "samples close the mesh on the area's walls, which nothing was touched for: there it is no surface of the "
                    "object",
                    evidence.assumes_clear ? ", hangs together there with what the seeds touched" : "", evidence.wall_samples)};
}

Premise reach_premise(const Options& options, const Evidence& evidence) {
    const double needed = options.epsilon / kMaxEpsilonPerReach;
    if (evidence.has_area) return {Kind::reach, State::missing, "none holds where the surface meets the walls around the area"};
    if (evidence.reach && evidence.reach->refuted) {
        return {Kind::reach, State::refuted,
                fmt::format("the given bound of {:.6g} mm is false: {}; the largest bound that the touches allow is {:.6g} mm; the mesh "
                            "rests on {:.6g} mm, and {:.6g} mm is needed",
                            *options.reach, evidence.reach->detail, evidence.reach->largest, evidence.reach->used, needed)};
    }
    if (!options.reach)
        return {Kind::reach, State::missing, fmt::format("no reach bound given; a reach of at least {:.6g} mm would do", needed)};
    if (*options.reach < needed) {
        return {Kind::reach, State::missing,
                fmt::format("the given bound of {:.6g} mm is too small: this epsilon needs {:.6g} mm", *options.reach, needed)};
    }
    const bool is_idle = evidence.reach && evidence.reach->is_plausible;
    return {Kind::reach, State::assumed,
            fmt::format("by the user: reach >= {:.6g} mm; {:.6g} mm is needed{}", *options.reach, needed,
                        is_idle ? "; no touch was held against it, as nothing was inferred from it" : "")};
}

// The largest share of wrong ones that leaves a chance of 5 % to find so few among those (Clopper and Pearson 1934); 1 if none were looked
// at.
double largest_share(std::uint64_t wrong, std::uint64_t of) {
    constexpr double kChance = 0.05;
    if (wrong >= of) return 1;
    const auto chance = [&](double share) {
        // The smallest terms are below what a double holds.
        long double term = std::pow(1 - static_cast<long double>(share), static_cast<long double>(of));
        long double sum = term;
        for (std::uint64_t k = 1; k <= wrong; ++k) {
            term *= share / (1 - share) * static_cast<long double>(of - k + 1) / static_cast<long double>(k);
            sum += term;
        }
        return sum;
    };
    double low = 0;
    double high = 1;
    for (int k = 0; k < 50; ++k) {
        const double middle = (low + high) / 2;
        (chance(middle) > kChance ? low : high) = middle;
    }
    return high;
}

// Two digits, rounded up.
std::string percent_text(double share) {
    const double percent = 100 * share;
    const double step = percent < 1 ? 0.01 : percent < 10 ? 0.1 : 1;
    return fmt::format("{:.{}f}", std::ceil(percent / step - 1e-9) * step, percent < 1 ? 2 : percent < 10 ? 1 : 0);
}

// Facets that no touch put into the mesh, and what they rest on.
Premise inference_premise(const ReachEvidence& reach) {
    const std::string audit = fmt::format("{} more, drawn at random, were touched anyway, {} of them not where they were {}", reach.audited,
                                          reach.audited_wrong, reach.is_plausible ? "expected" : "inferred");
    const std::string barred =
        reach.audit_barred > 0 ? fmt::format("; no way led to {} others that were drawn", reach.audit_barred) : std::string();
    if (!reach.is_plausible) {
        return {Kind::inference, State::assumed,
                fmt::format("{} facets, with their balls, are inferred from {}; {}{}", reach.inferred,
                            reach.refuted ? "the lowered bound" : "the given bound", audit, barred)};
    }
    return {Kind::inference, State::missing,
            fmt::format("{} facets, with their balls, are plausible by the samples around them, and not proven, the least of them with {} "
                        "%; {}: with 95 % confidence at most {} % are wrong, of those that a touch can reach{}",
                        reach.inferred, std::floor(100 * reach.least_confidence), audit,
                        percent_text(largest_share(reach.audited_wrong, reach.audited)), barred)};
}

Premise touch_premise(const Evidence& evidence) {
    Premise premise{Kind::exact_touches, State::assumed, "by the user: their error is far below epsilon"};
    if (evidence.touch_error > 0)
        premise.detail = fmt::format("by the machine's configuration: their error is at most {:.6g} mm", evidence.touch_error);
    if (evidence.grazes > 0) premise.detail += fmt::format("; {} were taken back by a later probe of the same edge", evidence.grazes);
    if (evidence.failed_probes > 0)
        premise.detail += fmt::format("; {} places could not be measured and are not in the mesh", evidence.failed_probes);
    return premise;
}

Premise facet_premise(const Evidence& evidence) {
    return {Kind::sizing_and_angles, evidence.bad_facets == 0 ? State::checked : State::refuted,
            fmt::format("{} facets do not fulfil them, away from seed facets", evidence.bad_facets)};
}

// Of O itself, not of Ŝ: what S was seen to do between samples.
Premise thickness_premise(const Evidence& evidence) {
    if (!evidence.stopped_by.empty()) {
        return {Kind::thickness, State::missing,
                fmt::format("at {} places S is met twice near each other, and a budget ended the run before they were refined",
                            evidence.unresolved_places + evidence.minor_places)};
    }
    if (evidence.unresolved_places > 0) {
        return {Kind::thickness, State::refuted,
                fmt::format("at {} places; the mesh does not have O's topology there", evidence.unresolved_places)};
    }
    return {Kind::thickness, State::refuted,
            fmt::format("at {} places the mesh leaves out a sharp edge or a wall, less than epsilon of it", evidence.minor_places)};
}

Premise earlier_premise(const EarlierEvidence& earlier) {
    const bool shows_all = earlier.directions == 3;
    return {
        Kind::earlier_touches, shows_all ? State::checked : State::assumed,
        fmt::format("{}{} touches of an earlier run were taken over, {} of them as samples; {} places were touched again, the worst was "
                    "{:.3g} mm off, the limit is {:.3g} mm; a shift would have shown in {} of 3 directions",
                    shows_all ? "" : "by the user: ", earlier.touches, earlier.samples, earlier.checked, earlier.worst, earlier.limit,
                    earlier.directions)};
}

// By prediction and by chance: it never makes the mesh more than it is, nor less.
Premise deviation_premise(const DeviationEvidence& deviation, bool in_box) {
    const bool holds =
        deviation.audited > 0 && deviation.unmet_facets == 0 && deviation.foretold <= deviation.tolerance && deviation.beyond == 0;
    std::string detail = fmt::format("99 % of the curved surface{} are within {:.6g} mm, as {} touches foretold and found; ",
                                     in_box ? " in the box of the tolerance" : "", deviation.tolerance, deviation.touched);
    if (deviation.unmet_facets > 0 || deviation.foretold > deviation.tolerance) {
        detail += fmt::format(
            "at {} facets it is foretold to be off by up to {:.3g} mm, and no touch can help there: samples are as near to each "
            "other as they may be, or nothing was met; ",
            deviation.unmet_facets, deviation.foretold);
    }
    detail += fmt::format(
        "{} places, drawn at random by area, were touched, {} of them farther off, the worst by {:.3g} mm: with 95 % confidence "
        "less than {} % are{}",
        deviation.audited, deviation.beyond, deviation.worst, percent_text(largest_share(deviation.beyond, deviation.audited)),
        deviation.barred > 0 ? fmt::format("; at {} others nothing was met", deviation.barred) : std::string());
    return {Kind::deviation, holds ? State::checked : State::missing, std::move(detail)};
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
        case Kind::deviation:
            return "within the tolerance";
        case Kind::known_solids:
            return "known solids";
        case Kind::within_area:
            return "only within the area";
        case Kind::earlier_touches:
            return "the object has not moved";
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
    if (evidence.reach) certificate.premises.push_back(inference_premise(*evidence.reach));
    if (evidence.deviation) certificate.premises.push_back(deviation_premise(*evidence.deviation, options.tolerance_box.has_value()));
    if (evidence.has_fixtures) certificate.premises.push_back(known_solids_premise(evidence));
    if (evidence.has_area) certificate.premises.push_back(area_premise(evidence));
    if (evidence.earlier) certificate.premises.push_back(earlier_premise(*evidence.earlier));
    if (evidence.has_facet_criteria) certificate.premises.push_back(facet_premise(evidence));
    const bool guesses = evidence.reach && evidence.reach->inferred > 0 && !certificate.find(Kind::inference)->holds();
    const bool is_shaped = !evidence.has_facet_criteria || certificate.find(Kind::sizing_and_angles)->holds();
    if (!evidence.stopped_by.empty()) {
        certificate.status = Certificate::Status::incomplete;
        certificate.premises.push_back({Kind::own_end, State::refuted, fmt::format("the budget of {} is used up", evidence.stopped_by)});
        certificate.statement =
            fmt::format("Nothing is guaranteed: the budget of {} ended the run before it was done. The mesh is what it knew then.",
                        evidence.stopped_by);
        return certificate;
    }
    if (!is_shaped || !manifold.holds() || !components.holds() || !balls.holds() || evidence.unresolved_places > 0) {
        certificate.status = Certificate::Status::incomplete;
        certificate.statement = "Nothing is guaranteed: the run could not establish all that it has to establish.";
    } else if (reach.state == State::refuted) {
        const bool enough = evidence.reach->used * kMaxEpsilonPerReach >= options.epsilon;
        certificate.status = Certificate::Status::refuted;
        certificate.statement = fmt::format(
            "The given bound on the reach is false. The mesh is a closed oriented manifold whose surface Delaunay balls are at most "
            "epsilon; {}",
            enough ? "it is isotopic to the object's surface if the lowered bound holds, which no touch contradicts."
                   : "the lowered bound is too small for this epsilon to guarantee that it has the object's topology.");
    } else if (!reach.holds() || evidence.minor_places > 0 || guesses) {
        certificate.status = Certificate::Status::conditional;
        certificate.statement = fmt::format(
            "The mesh is a closed oriented manifold whose surface Delaunay balls are at most epsilon{}; that it has the object's topology "
            "is "
            "not guaranteed, because {}: gaps, holes and walls that are narrower than about epsilon may be missing, too.",
            guesses ? ", as far as its plausible facets are right" : "",
            !reach.holds()              ? "the premise on the reach is missing"
            : evidence.minor_places > 0 ? "the object has sharp edges or walls that no reach allows"
                                        : "not all of its facets are proven");
        if (evidence.minor_places > 0)
            certificate.statement +=
                fmt::format(" At {} named places it ends before a sharp edge or a thin wall does.", evidence.minor_places);
        if (guesses) certificate.statement += " Some of its facets are plausible only.";
        if (evidence.has_area) {
            certificate.statement +=
                " The object is what of it lies within the area, with walls around; nothing is said of what is outside, and the result is "
                "open "
                "there.";
        }
    } else {
        certificate.status = Certificate::Status::certified;
        certificate.statement =
            "As far as the assumed premises hold, the mesh is isotopic to the object's surface and at Fréchet distance "
            "O(epsilon²/reach) from it (Oudot 2005, section 1.2).";
    }
    return certificate;
}

}  // namespace palpate
