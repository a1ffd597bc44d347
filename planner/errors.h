// What a run of the planner throws besides what its oracle throws.
#pragma once

#include <stdexcept>

namespace palpate {

// No way to start: a seed ray touches nothing, or the object is too small for ε. The message says what to give.
class SeedError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

// A touch contradicts an earlier answer: the object moved, or a touch was false.
class ContradictionError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

}  // namespace palpate
