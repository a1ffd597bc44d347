#include "sim/motion_audit.h"

#include <algorithm>
#include <array>

namespace palpate {

bool MotionAudit::deep(const Point& p) const { return obstacle_.depth(p) > kDepth * obstacle_.scale(); }

// Between two crossings a move is on one side of S; a few points of every stretch tell which one, and how deep.
bool MotionAudit::enters(const Segment& move) const {
    constexpr std::array kShares{0.5, 0.25, 0.75};  // not the ends: those may be on S
    std::vector<Point> cuts = obstacle_.crossings(move);
    cuts.push_back(move.target);
    Point from = move.source;
    for (const Point& to : cuts) {
        if (std::ranges::any_of(kShares, [&](double share) { return deep(from + share * (to - from)); })) return true;
        from = to;
    }
    return deep(move.source) || deep(move.target);
}

void MotionAudit::record(const Segment& move) {
    ++moves_;
    distance_ += (move.target - move.source).norm();
    if (check_ && enters(move)) ++unsafe_moves_;
}

}  // namespace palpate
