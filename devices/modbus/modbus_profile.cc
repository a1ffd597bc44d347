#include "devices/modbus/modbus_profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "devices/errors.h"

namespace palpate {
namespace {

constexpr int kLastAddress = 65535;
constexpr int kWordBits = 16;
// Modbus application protocol 1.1b, 6.3 and 6.12: what one frame carries.
constexpr int kMaxReadRegisters = 125;
constexpr int kMaxWriteRegisters = 123;

constexpr std::array<std::string_view, kModbusFields> kNames{"control_word",
                                                             "target_x",
                                                             "target_y",
                                                             "target_z",
                                                             "velocity",
                                                             "acceleration",
                                                             "touch_probe_function",
                                                             "stop_on_touch",
                                                             "sequence",
                                                             "heartbeat",
                                                             "status_word",
                                                             "fault_code",
                                                             "actual_x",
                                                             "actual_y",
                                                             "actual_z",
                                                             "touch_probe_status",
                                                             "edge_counter",
                                                             "latched_x",
                                                             "latched_y",
                                                             "latched_z",
                                                             "sequence_echo",
                                                             "heartbeat_echo",
                                                             "min_x",
                                                             "min_y",
                                                             "min_z",
                                                             "max_x",
                                                             "max_y",
                                                             "max_z"};

bool is_position(ModbusField field) {
    return (field >= ModbusField::target_x && field <= ModbusField::target_z) ||
           (field >= ModbusField::actual_x && field <= ModbusField::actual_z) ||
           (field >= ModbusField::latched_x && field <= ModbusField::latched_z) || field >= ModbusField::min_x;
}

bool is_quantity(ModbusField field) { return is_position(field) || field == ModbusField::velocity || field == ModbusField::acceleration; }

[[noreturn]] void fail(std::string_view entry, const std::string& what) {
    throw std::invalid_argument(fmt::format("Modbus profile: {}: {}", entry, what));
}

void check_register(ModbusField field, const ModbusRegister& entry) {
    const std::string_view name = name_of(field);
    if (entry.bits != kWordBits && entry.bits != 2 * kWordBits) {
        fail(name, fmt::format("a width of {} bits; allowed: 16, 32", entry.bits));
    }
    if (!is_quantity(field) && (entry.bits != kWordBits || entry.is_signed)) fail(name, "is a word of bits or a counter; allowed: u16");
    if (entry.address < 0 || entry.address > kLastAddress + 1 - entry.registers()) {
        fail(name, fmt::format("the address {} is out of range; allowed: 0 to 65535, for all of its registers", entry.address));
    }
    if (!std::isfinite(entry.unit) || entry.unit <= 0.0) fail(name, "the unit is not greater than 0");
    if (!is_quantity(field) && entry.unit != 1.0) fail(name, "is a word of bits or a counter; allowed: a unit of 1");
    if (is_position(field) && !entry.is_signed) fail(name, "is a position and cannot be negative; allowed: s16, s32");
}

void check_bit(std::string_view name, int bit) {
    if (bit < 0 || bit >= kWordBits) fail(name, fmt::format("is {}; allowed: 0 to 15", bit));
}

void check_time(std::string_view name, Seconds time) {
    if (!(time.count() > 0.0) || !std::isfinite(time.count())) fail(name, "is not greater than 0 s");
}

void check_overlaps(const ModbusProfile& profile) {
    struct Entry {
        int first;
        int end;
        std::string_view name;
    };
    std::vector<Entry> entries;
    for (const ModbusField field : all_modbus_fields()) {
        entries.push_back({profile[field].address, profile[field].address + profile[field].registers(), name_of(field)});
    }
    entries.push_back({profile.identity.address, profile.identity.address + profile.identity.registers, "identity"});
    std::ranges::sort(entries, {}, &Entry::first);
    for (std::size_t i = 1; i < entries.size(); ++i) {
        if (entries[i].first < entries[i - 1].end) {
            fail(entries[i].name, fmt::format("lies on a register of {} ({})", entries[i - 1].name, entries[i].first));
        }
    }
}

void check_blocks(const ModbusProfile& profile) {
    int commanded = 0;
    for (const ModbusField field : all_modbus_fields()) {
        if (block_of(field) == ModbusBlock::command) commanded += profile[field].registers();
    }
    const ModbusSpan command = span_of(profile, ModbusBlock::command);
    if (command.registers != commanded) {
        fail("the command block", fmt::format("control_word to sequence fill {} registers of the {} that they span; allowed: no gaps, one "
                                              "frame carries them all",
                                              commanded, command.registers));
    }
    if (commanded > kMaxWriteRegisters) fail("the command block", "is too long for one frame; allowed: 123 registers");
    for (const auto& [block, name] :
         {std::pair{ModbusBlock::status, "the status block"}, std::pair{ModbusBlock::limits, "the limits block"}}) {
        const int registers = span_of(profile, block).registers;
        if (registers > kMaxReadRegisters) {
            fail(name, fmt::format("spans {} registers; allowed: 125, one frame carries them all", registers));
        }
    }
}

}  // namespace

std::string_view name_of(ModbusField field) { return kNames[static_cast<std::size_t>(field)]; }

ModbusBlock block_of(ModbusField field) {
    if (field < ModbusField::heartbeat) return ModbusBlock::command;
    if (field == ModbusField::heartbeat) return ModbusBlock::heartbeat;
    return field < ModbusField::min_x ? ModbusBlock::status : ModbusBlock::limits;
}

std::array<ModbusField, kModbusFields> all_modbus_fields() {
    std::array<ModbusField, kModbusFields> fields{};
    for (std::size_t i = 0; i < kModbusFields; ++i) fields[i] = static_cast<ModbusField>(i);
    return fields;
}

ModbusField axis_of(ModbusField x, int axis) {
    assert(name_of(x).ends_with("_x") && axis >= 0 && axis < 3);
    return static_cast<ModbusField>(static_cast<int>(x) + axis);
}

ModbusProfile ModbusProfile::standard() {
    constexpr double kMicrometre = 0.001;  // mm
    const auto word = [](int address) { return ModbusRegister{address, 16, false, 1.0}; };
    const auto position = [](int address) { return ModbusRegister{address, 32, true, kMicrometre}; };
    const auto rate = [](int address) { return ModbusRegister{address, 32, false, kMicrometre}; };
    ModbusProfile profile;
    profile.identity = {1024, 16};
    profile.expected_identity = "palpate";
    profile.read_write = true;
    profile.registers = {
        word(256),     position(257), position(259), position(261), rate(263),     rate(265),     word(267),
        word(268),     word(269),     word(288),     word(512),     word(513),     position(514), position(516),
        position(518), word(520),     word(521),     position(522), position(524), position(526), word(528),
        word(529),     position(768), position(770), position(772), position(774), position(776), position(778),
    };
    return profile;
}

void check_profile(const ModbusProfile& profile) {
    for (const ModbusField field : all_modbus_fields()) check_register(field, profile[field]);
    const ModbusSpan& identity = profile.identity;
    if (identity.registers < 1 || identity.registers > kMaxReadRegisters) {
        fail("identity", fmt::format("{} registers; allowed: 1 to 125", identity.registers));
    }
    if (identity.address < 0 || identity.address > kLastAddress + 1 - identity.registers) {
        fail("identity", fmt::format("the address {} is out of range; allowed: 0 to 65535, for all of its registers", identity.address));
    }
    check_bit("homed_bit", profile.homed_bit);
    check_bit("probe_closed_bit", profile.probe_closed_bit);
    check_time("heartbeat_limit", profile.heartbeat_limit);
    check_time("echo_limit", profile.echo_limit);
    check_overlaps(profile);
    check_blocks(profile);
}

ModbusSpan span_of(const ModbusProfile& profile, ModbusBlock block) {
    int first = kLastAddress + 1;
    int end = 0;
    for (const ModbusField field : all_modbus_fields()) {
        if (block_of(field) != block) continue;
        first = std::min(first, profile[field].address);
        end = std::max(end, profile[field].address + profile[field].registers());
    }
    return {first, end - first};
}

void put_value(std::span<std::uint16_t> words, int first_address, const ModbusProfile& profile, ModbusField field, double value) {
    const ModbusRegister& entry = profile[field];
    const double counts = std::round(value / entry.unit);
    const double low = entry.is_signed ? -std::exp2(entry.bits - 1) : 0.0;
    const double high = std::exp2(entry.is_signed ? entry.bits - 1 : entry.bits) - 1.0;
    if (!(counts >= low && counts <= high)) {
        throw OutOfLimits(fmt::format("{} = {:f} does not fit the {} bits that the controller has for it; nothing was sent", name_of(field),
                                      value, entry.bits));
    }
    const auto bits = static_cast<std::uint32_t>(static_cast<std::int64_t>(counts));
    const auto at = static_cast<std::size_t>(entry.address - first_address);
    assert(entry.address >= first_address && at + static_cast<std::size_t>(entry.registers()) <= words.size());
    const auto low_word = static_cast<std::uint16_t>(bits & 0xFFFFU);
    const auto high_word = static_cast<std::uint16_t>(bits >> 16U);
    if (entry.bits == kWordBits) {
        words[at] = low_word;
    } else {
        const bool high_first = profile.word_order == ModbusWordOrder::high_first;
        words[at] = high_first ? high_word : low_word;
        words[at + 1] = high_first ? low_word : high_word;
    }
}

double get_value(std::span<const std::uint16_t> words, int first_address, const ModbusProfile& profile, ModbusField field) {
    const ModbusRegister& entry = profile[field];
    const auto at = static_cast<std::size_t>(entry.address - first_address);
    assert(entry.address >= first_address && at + static_cast<std::size_t>(entry.registers()) <= words.size());
    if (entry.bits == kWordBits) return entry.unit * (entry.is_signed ? static_cast<std::int16_t>(words[at]) : words[at]);
    const bool high_first = profile.word_order == ModbusWordOrder::high_first;
    const std::uint32_t bits = (static_cast<std::uint32_t>(words[high_first ? at : at + 1]) << 16U) | words[high_first ? at + 1 : at];
    return entry.unit * (entry.is_signed ? static_cast<double>(static_cast<std::int32_t>(bits)) : static_cast<double>(bits));
}

std::uint16_t get_word(std::span<const std::uint16_t> words, int first_address, const ModbusProfile& profile, ModbusField field) {
    const auto at = static_cast<std::size_t>(profile[field].address - first_address);
    assert(profile[field].bits == kWordBits && at < words.size());
    return words[at];
}

std::string text_of_registers(std::span<const std::uint16_t> words) {
    std::string text;
    for (const std::uint16_t word : words) {
        for (const auto byte : {static_cast<char>(word >> 8U), static_cast<char>(word & 0xFFU)}) text += byte;
    }
    text.resize(std::min(text.size(), text.find('\0')));
    text.resize(text.find_last_not_of(' ') + 1);  // npos + 1 is 0
    return text;
}

std::vector<std::uint16_t> registers_of_text(std::string_view text, int registers) {
    std::vector<std::uint16_t> words(static_cast<std::size_t>(registers), 0);
    for (std::size_t i = 0; i < std::min(text.size(), 2 * words.size()); ++i) {
        const auto byte = static_cast<std::uint16_t>(static_cast<unsigned char>(text[i]));
        words[i / 2] = static_cast<std::uint16_t>(words[i / 2] | (i % 2 == 0 ? byte << 8U : byte));
    }
    return words;
}

}  // namespace palpate
