// Moves that wait for their turn on a virtual tool, and the one under way.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "sim/virtual_tool.h"

namespace palpate {

struct GrblMove {
    Point target;  // machine coordinates
    double feed_mm_per_s = 0.0;
    VirtualTool::Guard guard = VirtualTool::Guard::none;
};

// Every move goes from rest to rest.
class GrblPlanner {
public:
    static constexpr std::size_t kBlocks = 15;

    // `tool` must outlive the planner.
    explicit GrblPlanner(VirtualTool& tool) : tool_(tool) {}

    // REQUIRES: free_blocks() > 0.
    void add(const GrblMove& move);
    // The tool may have come to rest: what was under way has ended, and the next move begins.
    void update();
    // Slows down, and keeps what is left of the move.
    void hold();
    // Goes on. REQUIRES: is_held_at_rest().
    void resume();
    // Slows down, and forgets all moves.
    void cancel();
    // Forgets all moves. REQUIRES: the tool rests.
    void clear();

    [[nodiscard]] bool is_empty() const { return !current_ && waiting_.empty(); }
    [[nodiscard]] bool is_held_at_rest() const { return holding_ && !tool_.is_moving(); }
    [[nodiscard]] std::size_t free_blocks() const { return kBlocks - waiting_.size(); }
    // Where the last of the moves ends.
    [[nodiscard]] std::optional<Point> last_target() const;

private:
    void start(const GrblMove& move);

    VirtualTool& tool_;
    std::deque<GrblMove> waiting_;
    std::optional<GrblMove> current_;
    bool holding_ = false;
};

}  // namespace palpate
