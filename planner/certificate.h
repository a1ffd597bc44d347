// What the mesh guarantees, and on which assumptions (planner/DESIGN.md, "Guarantees").
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "planner/deviation_evidence.h"
#include "planner/options.h"
#include "planner/topology.h"

namespace palpate {

struct Premise {
    enum class Kind {
        closed_oriented_manifold,  // I1
        every_component,           // I2: a vertex on each
        small_balls,               // I3: of radius epsilon at most
        reach,                     // epsilon is at most kMaxEpsilonPerReach of it
        object_in_workspace,       // ω contains O
        exact_touches,             // they lie on S, as far as the oracle says
        thickness,                 // no wall is thinner than samples show
        inference,                 // facets that no touch put into the mesh
        sizing_and_angles,         // facets fulfil what was asked for
        own_end,                   // no budget ended the run
        deviation,                 // the curved surface is within the tolerance
        known_solids,              // fixtures are where they are said to be, and nothing else stands on them
        within_area,               // an area alone was probed
        earlier_touches,           // the object is where it was when an earlier run touched it
    };
    enum class State {
        checked,  // on the result
        assumed,  // by whom the detail names
        refuted,  // the detail gives the evidence
        missing,  // nobody gave it: what rests on it is not guaranteed
    };
    Kind kind = Kind::reach;
    State state = State::missing;
    std::string detail;

    [[nodiscard]] bool holds() const { return state == State::checked || state == State::assumed; }
};

// As people and summary.json call it: "I1: closed oriented manifold".
[[nodiscard]] const char* name_of(Premise::Kind kind);

struct Certificate {
    enum class Status {
        certified,    // every premise is checked, or assumed by the user: Ŝ is isotopic to S
        conditional,  // what can be checked holds, but a premise is missing
        refuted,      // a premise that the user gave is contradicted by the touches
        incomplete,   // the run could not establish what it has to establish
    };
    Status status = Status::incomplete;
    std::vector<Premise> premises;  // one of each kind at most
    std::string statement;          // what is guaranteed, in one sentence

    // Nothing if that kind did not matter.
    [[nodiscard]] const Premise* find(Premise::Kind kind) const;
};

// A place where the run could not make Ŝ a manifold, and the ε that would be needed there.
struct BadPlace {
    Point position = Point::Zero();
    std::string what;
    double epsilon_needed = 0.0;  // mm, an upper bound: nothing larger can do
};

// What became of the bound on the reach (planner/DESIGN.md, "Inference").
struct ReachEvidence {
    bool refuted = false;
    double largest = std::numeric_limits<double>::infinity();  // mm: no larger bound agrees with the touches
    bool is_plausible = false;                                 // facets rest on what samples around them show, on no bound
    double used = 0.0;                                         // mm: the bound that the mesh rests on, if it rests on one
    std::string detail;                                        // which touch contradicts, and what
    std::uint64_t inferred = 0;                                // facets of the mesh that rest on it, or are plausible, untouched
    std::uint64_t audited = 0;                                 // inferred facets that were touched anyway
    std::uint64_t audited_wrong = 0;                           // of those: S was not met where it was inferred to be
    std::uint64_t audit_barred = 0;                            // drawn for the audit, but no way led there
    double least_confidence = 1.0;                             // of the plausible facets
};

// What became of an earlier run's touches.
struct EarlierEvidence {
    std::uint64_t touches = 0;  // taken over
    std::uint64_t samples = 0;  // of those
    std::uint64_t checked = 0;  // places touched again
    int directions = 0;         // independent ones, 0 to 3, in which they would have shown a shift
    double limit = 0.0;         // mm: farther off, the object has moved
    double worst = 0.0;         // mm: of those places, off where they were
};

// What the certificate rests on, as found on the result.
struct Evidence {
    double max_ball_radius = 0.0;                // mm: of facets that a touch or a proof put into the mesh
    double max_plausible_ball_radius = 0.0;      // mm: of the others
    std::size_t components = 0;                  // of Ŝ
    std::size_t unrepresented_touches = 0;       // samples that no facet of Ŝ uses; all around them was explored, unless a budget ended it
    std::size_t unresolved_places = 0;           // with such samples, or where S crosses dual edges twice: O is thinner than samples show
    std::size_t minor_places = 0;                // places as unresolved_places counts them, but Ŝ has O's topology without them
    std::size_t torn_components = 0;             // pairs of components of Ŝ that may be one
    std::size_t given_up = 0;                    // places where work led to nothing
    std::size_t known_samples = 0;               // on known solids: not touched
    std::size_t wall_samples = 0;                // of those: around the area that alone was probed
    bool has_fixtures = false;                   // the user gave some, ...
    bool has_area = false;                       // ... or an area that alone is to be probed, ...
    bool assumes_clear = false;                  // ... and says that nothing but the object stands on what is known
    std::size_t open_edges = 0;                  // of Ŝ, left unexplored
    bool has_facet_criteria = false;             // sizing or angles were asked for
    std::size_t bad_facets = 0;                  // facets that do not fulfil sizing or angles
    std::string stopped_by;                      // the budget that ended the run; empty: it ended by itself
    std::uint64_t failed_probes = 0;             // without an answer
    std::uint64_t grazes = 0;                    // contacts that a later probe took back
    bool seeds_given = false;                    // by the user, one per component
    double touch_error = 0.0;                    // mm: of the oracle's touches, as it states it
    std::optional<DeviationEvidence> deviation;  // with a tolerance
    std::optional<EarlierEvidence> earlier;      // if there was an earlier run
    std::optional<ReachEvidence> reach;          // of inference, if there was any
};

// Largest ε / rch(S) for which thesis 1.2 holds (µ0).
inline constexpr double kMaxEpsilonPerReach = 0.16;

[[nodiscard]] Certificate certify(const Options& options, const Topology& topology, const Evidence& evidence);

}  // namespace palpate
