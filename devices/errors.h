// What a device throws. Expected outcomes (contact, reached) are values, not exceptions.
#pragma once

#include <stdexcept>
#include <string>

#include "planner/geometry.h"

namespace palpate {

// A fault of a device or of the way to it. The run can be resumed once the cause is gone.
class DeviceError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

// The probe touched something where the planner had proven space free: the part moved, a false trigger, or a false bound.
class UnexpectedContact : public DeviceError {
public:
    UnexpectedContact(const Point& where, const std::string& during) : DeviceError(message(where, during)), where_(where) {}

    [[nodiscard]] const Point& where() const { return where_; }

private:
    static std::string message(const Point& where, const std::string& during);
    Point where_;
};

}  // namespace palpate
