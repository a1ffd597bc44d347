// Independent account of where a tool went: did it leave the area that alone is to be probed?
#pragma once

#include <cstdint>

#include "planner/area.h"
#include "planner/geometry.h"

namespace palpate {

// By where the way crosses the area's outline, not by the walls that the planner puts around it, so that an error there shows.
class AreaAudit {
public:
    // What is outside the workspace is no matter. `tolerance` (mm): so far a place may be in the workspace and out of the area.
    AreaAudit(Area area, const Box& workspace, double tolerance);

    void record(const Segment& move);
    [[nodiscard]] std::uint64_t moves_out() const { return moves_out_; }

private:
    Area area_;
    Box workspace_;
    double tolerance_;
    std::uint64_t moves_out_ = 0;
};

}  // namespace palpate
