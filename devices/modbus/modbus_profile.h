// Where a Modbus controller keeps what: its register map as a value, so that another controller needs no code.
//
// The objects and their bits follow CiA 402 (control word 6040h, status word 6041h, touch probe 60B8h to 60D5h) and PLCopen's
// MC_TouchProbe. What the standards leave open is fixed here:
//
//   Command   One FC16 frame carries the whole command block. The controller starts a move when the frame brings a sequence number
//             other than the one that it echoes; the same number again starts nothing. While it moves it answers a new command with
//             exception 6 (busy) and goes on; of the control word on its own the halt bit, the fault-reset bit and the enabling
//             bits are taken, without which it slows down.
//   Standstill is bit 10 of the status word: set whenever the axes stand, for whatever reason.
//   Touch     Each command arms the touch probe afresh: the stored bits are cleared. With stop-on-touch set, the controller slows down
//             when the armed edge is stored. The edge counter counts the positive edges that were stored, one for a touch
//             however the contact chatters, and is never cleared.
//   Heartbeat The host writes a number that changes, the controller echoes it. When it does not change for `heartbeat_limit` while
//             the axes move, the controller slows down, stops and shows kHeartbeatFault; its position stays true. An echo may come
//             in one of the controller's next cycles, within `echo_limit`; so may that of a sequence number.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planner/machine_time.h"

namespace palpate {

enum class ModbusField : std::uint8_t {
    // The command block: written by the host, in one frame.
    control_word,
    target_x,
    target_y,
    target_z,
    velocity,
    acceleration,
    touch_probe_function,
    stop_on_touch,
    sequence,
    // Written by the host on its own.
    heartbeat,
    // The status block: read by the host, in one frame.
    status_word,
    fault_code,
    actual_x,
    actual_y,
    actual_z,
    touch_probe_status,
    edge_counter,
    latched_x,
    latched_y,
    latched_z,
    sequence_echo,
    heartbeat_echo,
    // The limits block: what the machine can reach, read once.
    min_x,
    min_y,
    min_z,
    max_x,
    max_y,
    max_z,
};
constexpr std::size_t kModbusFields = 28;

enum class ModbusBlock : std::uint8_t { command, heartbeat, status, limits };

[[nodiscard]] std::string_view name_of(ModbusField field);  // "target_x"
[[nodiscard]] ModbusBlock block_of(ModbusField field);
[[nodiscard]] std::array<ModbusField, kModbusFields> all_modbus_fields();
// The field of the next axes: axis 1 of target_x is target_y. REQUIRES: `x` names an x, 0 <= axis <= 2.
[[nodiscard]] ModbusField axis_of(ModbusField x, int axis);

// One value in the holding registers.
struct ModbusRegister {
    int address = 0;         // 0..65535, of its first register
    int bits = 16;           // 16 or 32: one or two registers
    bool is_signed = false;  // two's complement
    double unit = 1.0;       // of one count: mm, mm/s, mm/s²; 1 for words of bits and counters

    [[nodiscard]] int registers() const { return bits / 16; }
    friend bool operator==(const ModbusRegister&, const ModbusRegister&) = default;
};

enum class ModbusWordOrder : std::uint8_t { high_first, low_first };

struct ModbusSpan {
    int address = 0;
    int registers = 0;
};

struct ModbusProfile {
    std::string name = "standard";
    ModbusWordOrder word_order = ModbusWordOrder::high_first;  // of 32-bit values
    // Text, two characters a register, the first in the high byte.
    ModbusSpan identity;
    std::string expected_identity;   // what it has to begin with; another controller is refused
    int homed_bit = 14;              // of the status word: the position is true
    int probe_closed_bit = 7;        // of the touch-probe status: the input as it is now
    Seconds heartbeat_limit{0.250};  // silence after which the controller stops
    Seconds echo_limit{0.5};         // so late it may echo a heartbeat or a command
    bool read_write = false;         // it knows FC23: a heartbeat and the status in one request. Tried once; without it two are used
    std::array<ModbusRegister, kModbusFields> registers{};

    [[nodiscard]] const ModbusRegister& operator[](ModbusField field) const { return registers[static_cast<std::size_t>(field)]; }
    [[nodiscard]] ModbusRegister& operator[](ModbusField field) { return registers[static_cast<std::size_t>(field)]; }

    // Ours: what sim/virtual_modbus serves and config/profiles/standard.yaml writes down.
    [[nodiscard]] static ModbusProfile standard();
};

// Throws std::invalid_argument that names the entry: address out of range, width that is not 16 or 32 (16 for words), unit that is not
// positive (1 for words), positions that cannot be negative, two entries on one register, a command block with gaps, a block too
// long for one frame, bits outside of 0..15, times that are not positive.
void check_profile(const ModbusProfile& profile);

// The least span that holds a block.
[[nodiscard]] ModbusSpan span_of(const ModbusProfile& profile, ModbusBlock block);

// Puts a value, in its unit, into words that begin at `first_address`. Throws OutOfLimits if it does not fit the width.
// REQUIRES: the words cover the field.
void put_value(std::span<std::uint16_t> words, int first_address, const ModbusProfile& profile, ModbusField field, double value);
[[nodiscard]] double get_value(std::span<const std::uint16_t> words, int first_address, const ModbusProfile& profile, ModbusField field);
// The same for words of bits and counters.
[[nodiscard]] std::uint16_t get_word(std::span<const std::uint16_t> words, int first_address, const ModbusProfile& profile,
                                     ModbusField field);

// Text in registers; what follows a zero byte is dropped, and so are trailing blanks.
[[nodiscard]] std::string text_of_registers(std::span<const std::uint16_t> words);
[[nodiscard]] std::vector<std::uint16_t> registers_of_text(std::string_view text, int registers);

}  // namespace palpate
