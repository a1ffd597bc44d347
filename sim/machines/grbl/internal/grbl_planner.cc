#include "sim/machines/grbl/internal/grbl_planner.h"

#include <algorithm>
#include <cassert>

namespace palpate {

void GrblPlanner::add(const GrblMove& move) {
    assert(free_blocks() > 0);
    waiting_.push_back(move);
    update();
}

void GrblPlanner::update() {
    if (holding_) return;
    while (!tool_.is_moving()) {
        current_.reset();
        if (waiting_.empty()) return;
        const GrblMove next = waiting_.front();
        waiting_.pop_front();
        start(next);
    }
}

void GrblPlanner::start(const GrblMove& move) {
    current_ = move;
    tool_.start_move(move.target, feed_of(move), move.guard);
}

double GrblPlanner::feed_of(const GrblMove& move) const {
    if (move.override_by == GrblMove::Override::none) return move.feed_mm_per_s;
    const int percent = move.override_by == GrblMove::Override::feed ? overrides_.feed : overrides_.rapid;
    return std::max(kMinimumFeed, std::min(move.feed_mm_per_s * percent / 100.0, move.fastest_mm_per_s));
}

void GrblPlanner::set_overrides(const GrblOverrides& overrides) {
    overrides_ = overrides;
    if (current_) tool_.change_feed(feed_of(*current_));
}

void GrblPlanner::hold() {
    holding_ = true;
    tool_.decelerate();
}

void GrblPlanner::resume() {
    assert(is_held_at_rest());
    holding_ = false;
    // A move that its trigger has ended does not go on.
    if (current_ && !tool_.trigger()) start(*current_);
    update();
}

void GrblPlanner::cancel() {
    waiting_.clear();
    tool_.decelerate();
    update();
}

void GrblPlanner::clear() {
    assert(!tool_.is_moving());
    waiting_.clear();
    current_.reset();
    holding_ = false;
}

std::optional<Point> GrblPlanner::last_target() const {
    if (!waiting_.empty()) return waiting_.back().target;
    return current_ ? std::optional(current_->target) : std::nullopt;
}

}  // namespace palpate
