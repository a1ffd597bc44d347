// Bits and codes in the words of a Modbus controller (devices/modbus/modbus_profile.h), as CiA 402 has them.
#pragma once

#include <cstdint>

namespace palpate::cia402 {

// Control word, 6040h.
constexpr std::uint16_t kShutdown = 0x0006;
constexpr std::uint16_t kSwitchOn = 0x0007;
constexpr std::uint16_t kEnableOperation = 0x000F;
constexpr std::uint16_t kNewSetPoint = 0x0010;
constexpr std::uint16_t kFaultReset = 0x0080;
constexpr std::uint16_t kHalt = 0x0100;

// Status word, 6041h.
constexpr std::uint16_t kReadyToSwitchOn = 0x0001;
constexpr std::uint16_t kSwitchedOn = 0x0002;
constexpr std::uint16_t kOperationEnabled = 0x0004;
constexpr std::uint16_t kFault = 0x0008;
constexpr std::uint16_t kVoltageEnabled = 0x0010;
constexpr std::uint16_t kQuickStopInactive = 0x0020;
constexpr std::uint16_t kSwitchOnDisabled = 0x0040;
constexpr std::uint16_t kStanding = 0x0400;
constexpr std::uint16_t kInternalLimit = 0x0800;

// Touch-probe function, 60B8h, and status, 60B9h.
constexpr std::uint16_t kProbeEnable = 0x0001;
constexpr std::uint16_t kProbePositiveEdge = 0x0010;
constexpr std::uint16_t kProbeNegativeEdge = 0x0020;
constexpr std::uint16_t kProbeEnabled = 0x0001;
constexpr std::uint16_t kPositiveEdgeStored = 0x0002;
constexpr std::uint16_t kNegativeEdgeStored = 0x0004;

// Error codes, 603Fh.
constexpr std::uint16_t kNoFault = 0x0000;
constexpr std::uint16_t kParameterFault = 0x6320;    // a move without a velocity or an acceleration
constexpr std::uint16_t kExternalFault = 0x9000;     // an emergency stop
constexpr std::uint16_t kHeartbeatFault = 0x8130;    // the host was silent
constexpr std::uint16_t kLimitFault = 0x8612;        // a target or a position beyond the limits
constexpr std::uint16_t kNotHomedFault = 0xFF01;     // a move was asked for before homing
constexpr std::uint16_t kProbeClosedFault = 0xFF02;  // a move towards a touch was asked for while the probe was closed

}  // namespace palpate::cia402
