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

// An expected contact stayed away, and so did that of a known place: nothing is to be believed that was found free since the last contact.
class SilenceError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

}  // namespace palpate
