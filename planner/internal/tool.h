// The tool as the planner sees it: at a node of the roadmap, with an account of all it did.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "planner/account.h"
#include "planner/internal/roadmap.h"
#include "planner/surface_oracle.h"
#include "planner/workspace.h"

namespace palpate {

class Tool {
public:
    // Brings the tool straight to ω's boundary. Throws std::invalid_argument if it starts inside ω: nothing proves that
    // any way from there is free. All arguments must outlive the tool.
    Tool(SurfaceOracle& oracle, const Workspace& workspace, Roadmap& roadmap);

    // Moves along segments of the roadmap.
    void go_to(NodeId node);

    struct Answer {
        bool contact = false;
        bool failed = false;  // the tool is where it was, and nothing is known
        Point position = Point::Zero();
        std::uint32_t touch = 0;  // number of the touch, with contact
    };
    // Probes straight from the node where the tool is. The caller makes the node where it is then, and says so: arrive(); not
    // so if that failed.
    Answer probe(const Point& target, Touch::Role role = Touch::Role::crossing);
    void arrive(NodeId node);
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
    [[nodiscard]] const Account& account() const { return account_; }
    [[nodiscard]] const std::vector<Touch>& touches() const { return touches_; }
    // Where the probe that touched the sample came from.
    [[nodiscard]] NodeId start_of_sample(std::uint32_t sample) const { return sample_starts_[sample]; }
    // A touch turned out to be more than a crossing.
    void assign(std::uint32_t touch, Touch::Role role, std::uint32_t sample);
    void end_of_seeding() { account_.seed = account_.probes(); }

private:
    Answer failed_at(const Point& from);
    Answer note_touch(NodeId start, const Point& touched, Touch::Role role);

    SurfaceOracle& oracle_;
    Roadmap& roadmap_;
    NodeId at_ = kNoNode;
    Contact contact_;
    bool touches_now_ = false;  // and has not arrived at a node yet
    Account account_;
    std::vector<Touch> touches_;
    std::vector<NodeId> touch_starts_;   // by touch
    std::vector<NodeId> sample_starts_;  // by sample
};

}  // namespace palpate
