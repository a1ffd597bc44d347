// The words that the journal has for values, and its schema.
#pragma once

#include <array>
#include <string_view>
#include <utility>

#include "devices/probe_device.h"

namespace palpate {

inline constexpr unsigned kJournalSchema = 2;  // it rises when a key goes or means something else; a further key is no change

inline constexpr std::string_view kDatumWay = "way";

inline constexpr std::array<std::pair<Pace, std::string_view>, 3> kPaceWords = {
    {{Pace::travel, "travel"}, {Pace::probe, "probe"}, {Pace::touch, "touch"}}};
inline constexpr std::array<std::pair<MoveResult::Outcome, std::string_view>, 4> kOutcomeWords = {
    {{MoveResult::Outcome::reached, "reached"},
     {MoveResult::Outcome::contact, "contact"},
     {MoveResult::Outcome::failed, "failed"},
     {MoveResult::Outcome::vanished, "vanished"}}};
inline constexpr std::array<std::pair<DeviceEvent::Kind, std::string_view>, 4> kEventWords = {
    {{DeviceEvent::Kind::spurious_trigger, "spurious_trigger"},
     {DeviceEvent::Kind::scattered_touch, "scattered_touch"},
     {DeviceEvent::Kind::repeated_command, "repeated_command"},
     {DeviceEvent::Kind::reconnected, "reconnected"}}};

template <typename Value, std::size_t N>
[[nodiscard]] constexpr std::string_view word_in(const std::array<std::pair<Value, std::string_view>, N>& words, Value value) {
    for (const auto& [known, word] : words) {
        if (known == value) return word;
    }
    return {};
}
[[nodiscard]] constexpr std::string_view word_of(Pace pace) { return word_in(kPaceWords, pace); }
[[nodiscard]] constexpr std::string_view word_of(MoveResult::Outcome outcome) { return word_in(kOutcomeWords, outcome); }
[[nodiscard]] constexpr std::string_view word_of(DeviceEvent::Kind kind) { return word_in(kEventWords, kind); }

}  // namespace palpate
