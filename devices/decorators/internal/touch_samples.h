// Touches of one place that have to agree.
#pragma once

#include <cstddef>
#include <vector>

namespace palpate {

// Places along one line, in mm, in the order in which they were touched.
class TouchSamples {
public:
    explicit TouchSamples(std::size_t needed) : needed_(needed) {}

    void add(double place) { places_.push_back(place); }
    void need_one_more() { ++needed_; }
    // One touch is all that was asked for.
    [[nodiscard]] bool is_alone() const { return needed_ == 1; }
    [[nodiscard]] bool is_complete() const { return places_.size() >= needed_; }
    [[nodiscard]] bool is_empty() const { return places_.empty(); }
    // None of these may be asked of an empty set.
    [[nodiscard]] double earliest() const { return places_.front(); }
    [[nodiscard]] double range() const;
    // Of an even number: the mean of the two in the middle.
    [[nodiscard]] double median() const;
    // Removes and returns the one farthest from the median; of several, the earliest: first touches are off most.
    double drop_farthest();

private:
    std::size_t needed_;
    std::vector<double> places_;
};

}  // namespace palpate
