// Moves that wait for their turn on a virtual tool, and the one under way.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "sim/machines/virtual_tool.h"

namespace palpate {

// In percent of what is programmed.
struct GrblOverrides {
    int feed = 100;
    int rapid = 100;
    int spindle = 100;
};

struct GrblMove {
    enum class Override { none, feed, rapid };

    Point target;                // machine coordinates
    double feed_mm_per_s = 0.0;  // as programmed
    VirtualTool::Guard guard = VirtualTool::Guard::none;
    Override override_by = Override::none;
    double fastest_mm_per_s = 0.0;  // by the settings, whatever the override
};

// Every move goes from rest to rest.
class GrblPlanner {
public:
    static constexpr std::size_t kBlocks = 15;
    // mm/s: the firmware goes no slower, whatever the line and $110 say (MINIMUM_FEED_RATE).
    static constexpr double kMinimumFeed = 1.0 / 60.0;

    // `tool` must outlive the planner.
    explicit GrblPlanner(VirtualTool& tool) : tool_(tool) {}

    // REQUIRES: free_blocks() > 0.
    void add(const GrblMove& move);
    // The tool may have come to rest: what was under way has ended, and the next move begins.
    void update();
    // Of the move under way, too, as a firmware that was built with ALLOW_FEED_OVERRIDE_DURING_PROBE_CYCLES, or grblHAL with $65.
    void set_overrides(const GrblOverrides& overrides);
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
    [[nodiscard]] double feed_of(const GrblMove& move) const;

    VirtualTool& tool_;
    std::deque<GrblMove> waiting_;
    std::optional<GrblMove> current_;
    GrblOverrides overrides_;
    bool holding_ = false;
};

}  // namespace palpate
