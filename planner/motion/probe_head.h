// The tool as the planner sees it: at a node of the roadmap, with the cost of all it did.
//
// Where a probe may die (Options::overtravel), the tool notices (devices/FACTS.md, "Safety floor"). A contact that is expected and stays
// away is asked for again; if it stays away again a known place is touched before anything else: a contact there makes the clear a finding,
// a clear there means that the probe is dead. Where nothing is expected a known place is touched after so many clears (probe_watch.h).
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "planner/cost.h"
#include "planner/motion/probe_watch.h"
#include "planner/motion/roadmap.h"
#include "planner/surface_oracle.h"
#include "planner/surroundings.h"
#include "planner/touch.h"

namespace palpate {

class ProbeHead {
public:
    // Brings the tool straight to ω's boundary. Throws std::invalid_argument if it starts inside ω: nothing proves that
    // any way from there is free. All arguments must outlive the tool.
    ProbeHead(SurfaceOracle& oracle, const Surroundings& surroundings, Roadmap& roadmap, const std::optional<ProbeWatch>& watch = {});

    // Moves along segments of the roadmap. Throws SilenceError as probe() does.
    void go_to(NodeId node);

    // What became of a guarded move. What vanished (ProbeAnswer) has been looked into: that is failed, or an answer.
    struct Answer {
        ProbeAnswer::Outcome outcome = ProbeAnswer::Outcome::clear;
        Point position = Point::Zero();  // where the tool is now
        std::uint32_t touch = 0;         // number of the touch, with contact
        bool on_free_way = false;        // with contact: where the way should have been free
        bool is_known = false;           // with contact: nothing was touched, but a known solid begins there

        [[nodiscard]] bool is_contact() const { return outcome == ProbeAnswer::Outcome::contact; }
        [[nodiscard]] bool is_failed() const { return outcome == ProbeAnswer::Outcome::failed; }
    };
    // A contact that is announced before the target: by a proof, a known crossing, a seed ray of the user's.
    struct Expected {
        Point before = Point::Zero();  // S is met no farther along than there
    };
    // Probes straight from the node where the tool is, and makes the way part of the roadmap: the tool is at a new node then, with a
    // contact, or at the destination's; after a failure where it was. Throws SilenceError if neither S nor a known place is touched where
    // it should be.
    Answer probe(const Destination& destination, Touch::Role role = Touch::Role::crossing, const std::optional<Expected>& expected = {});
    // S is known to be there, on a line from `from`: no motion. Returns the number of the touch that stands for it.
    std::uint32_t note_known(const Point& at, const Point& from);
    // The same of a place that an earlier run touched, from there.
    std::uint32_t note_earlier(const Point& at, const Point& from);
    // The node where the tool is and that one are at the same place.
    void stand_at(NodeId node);
    // The last contact: where it was, and where the tool came from, straight.
    struct Contact {
        NodeId at = kNoNode;
        NodeId from = kNoNode;
    };
    [[nodiscard]] const Contact& contact() const { return contact_; }
    // Back from that contact, where the tool is, to a point of the straight way to it. The contact stays a dead end of
    // the roadmap: no way leads through a place on S.
    void lift(const Point& to);
    // Moves, guarded, on a straight way that should be free, and makes it part of the roadmap. Answers if S is met there, or fails.
    std::optional<Answer> move_to(const Point& target);

    [[nodiscard]] NodeId at() const { return at_; }
    [[nodiscard]] const Cost& cost() const { return cost_; }
    [[nodiscard]] const std::vector<Touch>& touches() const { return touches_; }
    // Where the probe that touched the sample came from.
    [[nodiscard]] NodeId start_of_sample(std::uint32_t sample) const { return sample_starts_[sample]; }
    // A touch turned out to be more than a crossing.
    void assign(std::uint32_t touch, Touch::Role role, std::uint32_t sample);
    void end_of_seeding() { cost_.seed = cost_.probes(); }
    // A run ends with a contact: touches a known place if clears came since the last one.
    void end_of_run();
    // Back to where the tool began: back along the last approach, straight and guarded out of ω, around it outside. `say` hears how long
    // that is before it starts (mm).
    void go_home(const std::function<void(double)>& say);

private:
    // A touch that can be made again, straight from a node.
    struct KnownPlace {
        NodeId from = kNoNode;
        Point position = Point::Zero();
        bool straight = false;  // its start is best reached straight, guarded
    };

    // One guarded move from the node where the tool is; its length is added to `way`. What vanishes (ProbeAnswer) is looked into.
    ProbeAnswer ask(const Point& target, double& way);
    ProbeAnswer ask_expecting(const Point& target, const Expected& expected);
    // Straight back from where a probe ended to the node where it began.
    void go_back(const Point& from);
    // Over the roadmap; `slowly`: all of it at the feed of probes.
    void move_along(NodeId node, bool slowly);
    // Through points that were found to be free.
    void follow(const std::vector<Point>& points, bool slowly);
    // Why the probe may be dead.
    struct Doubt {
        enum Kind { many_clears, missed, vanished };
        Kind kind = many_clears;
        Point place = Point::Zero();  // where a contact was missed, or the end of the way on which one vanished
    };
    [[nodiscard]] std::string text(const Doubt& doubt);
    // Touches a known place on the way to `next`, where the tool is then (kNoNode: where it touched from). Throws SilenceError if that is
    // not touched either, or if none is known and nobody can show that the probe works.
    void show_alive(const Doubt& doubt, NodeId next);
    [[nodiscard]] bool touch_some(const KnownPlace& place, std::vector<Point>& passed_over);
    // Goes to its start and touches it, twice if need be; the tool is at the start then.
    [[nodiscard]] bool visit(const KnownPlace& place, bool slowly, bool twice);
    // Nothing if no touch that is known can be made again.
    [[nodiscard]] std::optional<KnownPlace> nearest_known(const std::vector<Point>& passed_over, NodeId next);
    // Straight to a node, guarded; false, and the tool is where it was, if something is met.
    [[nodiscard]] bool hop_to(NodeId node);
    void note_check(const ProbeAnswer& answer, NodeId from);
    [[nodiscard]] bool touch_again(const KnownPlace& place);
    [[nodiscard]] Answer failed();
    // Guarded from the node where the tool is to ω's boundary; false, and the tool is where it was, if something is met.
    [[nodiscard]] bool leave_along(const Vector& direction, double& way);
    // The tool came from where it was to S, which becomes a node; `is_known`: to the boundary of a known solid.
    Answer note_touch(const Point& touched, Touch::Role role, bool is_known = false);
    // No move leads into a known solid. Throws std::logic_error if that one does.
    void require_free_of_known(const Segment& move) const;

    SurfaceOracle& oracle_;
    const Surroundings surroundings_;
    Roadmap& roadmap_;
    std::optional<ProbeWatch> watch_;
    const Point home_;
    NodeId at_ = kNoNode;
    std::optional<KnownPlace> last_touched_;
    Contact contact_;
    Cost cost_;
    std::vector<Touch> touches_;
    std::vector<NodeId> touch_starts_;   // by touch
    std::vector<NodeId> sample_starts_;  // by sample
};

}  // namespace palpate
