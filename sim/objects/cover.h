// Which parameters of a line are covered by intervals.
#pragma once

#include <algorithm>
#include <vector>

#include "planner/geometry.h"

namespace palpate {

// Intervals that do not meet, in order.
class Cover {
public:
    void add(Interval interval) {
        const auto first = std::ranges::lower_bound(all_, interval.low, {}, &Interval::high);
        auto last = first;
        for (; last != all_.end() && last->low <= interval.high; ++last) {
            interval = {std::min(interval.low, last->low), std::max(interval.high, last->high)};
        }
        all_.insert(all_.erase(first, last), interval);
    }
    [[nodiscard]] bool contains(const Interval& interval) const {
        const auto first = std::ranges::lower_bound(all_, interval.high, {}, &Interval::high);
        return first != all_.end() && first->low <= interval.low;
    }
    [[nodiscard]] const std::vector<Interval>& intervals() const { return all_; }

private:
    std::vector<Interval> all_;
};

}  // namespace palpate
