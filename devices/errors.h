// What a device throws. Expected outcomes (contact, reached) are values, not exceptions.
//
//   DeviceError             any fault; the run can be resumed once the cause is gone
//     UnexpectedContact     a touch where space was proven free
//     ProbeClosed           the probe is closed where it has to be open: at the start of a move, at connect, after a retract
//     OutOfLimits           a move that would leave the limits; nothing was sent
//     ConnectionLost        the port or the peer is gone
//     DeviceTimeout         an answer did not come
//     DeviceRefused         the machine refused a command (GRBL error:N, a Modbus exception)
//     DeviceAlarm           the machine is in alarm, or locked
//     PositionLost          nobody knows where the tool is: home first
//     BadAnswer             an answer that cannot be true
//     Stopped               the operator asked for it
//   SetupError              what cannot begin as it was asked for; nothing has moved
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

#include "planner/geometry.h"

namespace palpate {

// What the system says of an error of its own (errno).
[[nodiscard]] std::string reason(int error);

class DeviceError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

// The probe touched something where the planner had proven space free: the part moved, a false trigger, or a false bound.
class UnexpectedContact : public DeviceError {
public:
    // `moves`: how many moves were made from the one that first touched it, that one included; 0 if that is not known to a journal.
    UnexpectedContact(const Point& where, const std::string& during, std::size_t moves = 0);

    [[nodiscard]] const Point& where() const { return where_; }
    [[nodiscard]] std::size_t moves() const { return moves_; }

private:
    Point where_;
    std::size_t moves_;
};

class ProbeClosed : public DeviceError {
public:
    using DeviceError::DeviceError;
};

class OutOfLimits : public DeviceError {
public:
    using DeviceError::DeviceError;
};

class ConnectionLost : public DeviceError {
public:
    using DeviceError::DeviceError;
};

class DeviceTimeout : public DeviceError {
public:
    using DeviceError::DeviceError;
};

class DeviceRefused : public DeviceError {
public:
    DeviceRefused(int code, const std::string& message) : DeviceError(message), code_(code) {}

    [[nodiscard]] int code() const { return code_; }

private:
    int code_;
};

class DeviceAlarm : public DeviceError {
public:
    // `code` 0: locked, and the machine did not say why.
    DeviceAlarm(int code, const std::string& message) : DeviceError(message), code_(code) {}

    [[nodiscard]] int code() const { return code_; }

private:
    int code_;
};

class PositionLost : public DeviceError {
public:
    using DeviceError::DeviceError;
};

class BadAnswer : public DeviceError {
public:
    using DeviceError::DeviceError;
};

class Stopped : public DeviceError {
public:
    using DeviceError::DeviceError;
};

// What cannot begin as it was asked for. The message says what to change.
class SetupError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

}  // namespace palpate
