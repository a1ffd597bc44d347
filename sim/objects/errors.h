// What building a hidden object throws when its description cannot be used.
#pragma once

#include <stdexcept>

namespace palpate {

// A shape's parameters or a mesh file that describe no solid. The message says what is wrong, where, and what to do.
class ObjectError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

}  // namespace palpate
