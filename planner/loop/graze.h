// An edge that was touched from one end and found clear from the other.
#pragma once

#include "planner/delaunay/edge_record.h"
#include "planner/motion/probe_head.h"

namespace palpate {

// Either rounding has put the two ways on two sides of S, which the edge grazes: then S is still there, on a line beside the first way. Or
// the world has changed: throws ContradictionError. For oracles whose touches are exact. `radius` (mm): ω's.
void expect_graze(ProbeHead& head, const Crossing& touched, double radius);

}  // namespace palpate
