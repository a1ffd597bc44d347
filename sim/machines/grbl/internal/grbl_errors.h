// Error numbers of the protocol ("error:N").
#pragma once

namespace palpate {

inline constexpr int kExpectedLetter = 1;
inline constexpr int kBadNumber = 2;
inline constexpr int kUnknownCommand = 3;
inline constexpr int kUnknownSetting = 3;
inline constexpr int kNegative = 4;
inline constexpr int kHomingDisabled = 5;
inline constexpr int kNotIdle = 8;
inline constexpr int kLocked = 9;
inline constexpr int kSoftLimitsNeedHoming = 10;
inline constexpr int kLineTooLong = 11;
inline constexpr int kJogBeyondLimits = 15;
inline constexpr int kNotAJog = 16;
inline constexpr int kUnsupported = 20;
inline constexpr int kModalGroup = 21;
inline constexpr int kNoFeed = 22;
inline constexpr int kNotWhole = 23;
inline constexpr int kAxisConflict = 24;
inline constexpr int kRepeatedWord = 25;
inline constexpr int kNoAxisWords = 26;
inline constexpr int kMissingValue = 28;
inline constexpr int kNoSuchWorkSystem = 29;
inline constexpr int kG53 = 30;
inline constexpr int kUselessAxisWords = 31;
inline constexpr int kAtTarget = 33;
inline constexpr int kUnusedWords = 36;
inline constexpr int kResetRequired = 79;

}  // namespace palpate
