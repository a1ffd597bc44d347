#include "sim/machines/modbus/virtual_modbus_controller.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "devices/errors.h"
#include "devices/modbus/modbus_bits.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

using F = ModbusField;

constexpr int kIllegalAddress = 2;
constexpr int kBusy = 6;

constexpr std::uint16_t kDisabled = cia402::kSwitchOnDisabled | cia402::kVoltageEnabled | cia402::kQuickStopInactive;
constexpr std::uint16_t kReady = cia402::kReadyToSwitchOn | cia402::kVoltageEnabled | cia402::kQuickStopInactive;

std::uint16_t bits(unsigned value) { return static_cast<std::uint16_t>(value); }

}  // namespace

VirtualModbusController::VirtualModbusController(const Obstacle& obstacle, const VirtualModbusOptions& options)
    : options_(options), tool_(obstacle, options.tool), is_homed_(options.homed), drive_state_(kDisabled) {
    const ModbusProfile& profile = options_.profile;
    check_profile(profile);
    std::vector<ModbusSpan> spans{profile.identity};
    for (const F field : all_modbus_fields()) spans.push_back({profile[field].address, profile[field].registers()});
    first_address_ = std::ranges::min(spans, {}, &ModbusSpan::address).address;
    int end = 0;
    for (const ModbusSpan& span : spans) end = std::max(end, span.address + span.registers);
    words_.assign(static_cast<std::size_t>(end - first_address_), 0);
    known_.assign(words_.size(), false);
    // Blocks are read whole, so their gaps answer too.
    for (const ModbusBlock block : {ModbusBlock::command, ModbusBlock::status, ModbusBlock::limits})
        spans.push_back(span_of(profile, block));
    for (const ModbusSpan& span : spans) std::fill_n(known_.begin() + (span.address - first_address_), span.registers, true);
    // Later everything that is told lies between the limits and the start.
    try {
        (void)registers();
    } catch (const OutOfLimits& error) {
        throw std::invalid_argument(fmt::format(
            "limits {} to {} and a start at {} (machine) are more than the virtual controller can tell: {}",
            point_text(options_.tool.limits.min), point_text(options_.tool.limits.max), point_text(options_.tool.start), error.what()));
    }
}

std::optional<int> VirtualModbusController::refuses_to_read(int address, int registers) const {
    for (int at = address - first_address_; at < address - first_address_ + registers; ++at) {
        if (at < 0 || at >= static_cast<int>(known_.size()) || !known_[static_cast<std::size_t>(at)]) return kIllegalAddress;
    }
    return std::nullopt;
}

bool VirtualModbusController::holds(F field, int address, int registers) const {
    const ModbusRegister& entry = options_.profile[field];
    return entry.address >= address && entry.address + entry.registers() <= address + registers;
}

std::optional<int> VirtualModbusController::refuses_to_write(int address, int registers) const {
    int host_registers = 0;
    bool is_command = false;
    for (const F field : all_modbus_fields()) {
        if (block_of(field) != ModbusBlock::command && block_of(field) != ModbusBlock::heartbeat) continue;
        if (!holds(field, address, registers)) continue;
        host_registers += options_.profile[field].registers();
        is_command = is_command || (block_of(field) == ModbusBlock::command && field != F::control_word);
    }
    if (host_registers != registers) return kIllegalAddress;
    if (is_command && tool_.is_moving()) return kBusy;
    return std::nullopt;
}

std::uint16_t VirtualModbusController::told(F field) const { return get_word(words_, first_address_, options_.profile, field); }

Point VirtualModbusController::told_target() const {
    Point target;
    for (int axis = 0; axis < 3; ++axis) {
        target[axis] = get_value(words_, first_address_, options_.profile, axis_of(F::target_x, axis));
    }
    return target;
}

void VirtualModbusController::write(int address, std::span<const std::uint16_t> words) {
    const int registers = static_cast<int>(words.size());
    if (holds(F::control_word, address, registers) || holds(F::sequence, address, registers)) ++commands_;
    if (options_.scan.count() > 0.0) {
        inbox_.emplace_back(address, std::vector<std::uint16_t>(words.begin(), words.end()));
    } else {
        take(address, words);
    }
}

void VirtualModbusController::take(int address, std::span<const std::uint16_t> words) {
    std::ranges::copy(words, words_.begin() + (address - first_address_));
    if (is_frozen_) return;
    const int registers = static_cast<int>(words.size());
    if (holds(F::heartbeat, address, registers) && told(F::heartbeat) != heartbeat_) {
        heartbeat_ = told(F::heartbeat);
        silence_ = Seconds(0);
    }
    const bool had_set_point = (control_word_ & cia402::kNewSetPoint) != 0;
    if (holds(F::control_word, address, registers)) control(told(F::control_word));
    if (!holds(F::sequence, address, registers) || told(F::sequence) == sequence_) return;
    const bool is_edge = !had_set_point && (control_word_ & cia402::kNewSetPoint) != 0;
    ++(is_edge ? set_points_ : commands_without_edge_);
    start();
}

void VirtualModbusController::control(std::uint16_t word) {
    const std::uint16_t before = std::exchange(control_word_, word);
    if (bits(drive_state_ & cia402::kFault) != 0) {
        if ((word & cia402::kFaultReset) != 0 && (before & cia402::kFaultReset) == 0) {
            drive_state_ = kDisabled;
            fault_code_ = cia402::kNoFault;
        }
        return;
    }
    const std::uint16_t command = word & cia402::kEnableOperation;
    if (command == cia402::kShutdown) {
        drive_state_ = kReady;
    } else if (command == cia402::kSwitchOn && (drive_state_ & cia402::kReadyToSwitchOn) != 0) {
        drive_state_ = kReady | cia402::kSwitchedOn;
    } else if (command == cia402::kEnableOperation && (drive_state_ & cia402::kSwitchedOn) != 0) {
        drive_state_ = kReady | cia402::kSwitchedOn | cia402::kOperationEnabled;
    } else if (command != cia402::kEnableOperation) {
        drive_state_ = kDisabled;
    }
    const bool is_enabled = (drive_state_ & cia402::kOperationEnabled) != 0;
    if (!tool_.is_moving()) return;
    const bool is_halt = (word & cia402::kHalt) != 0 && !suffers(MachineFault::ignored_halt);
    if (!is_enabled || is_halt) tool_.decelerate();
}

bool VirtualModbusController::suffers(MachineFault fault) {
    if (fault_ != fault) return false;
    fault_.reset();
    return true;
}

// Why a command is not carried out; kNoFault if it is.
std::uint16_t VirtualModbusController::objection(const Point& target, Armed armed) const {
    for (const F rate : {F::velocity, F::acceleration}) {
        if (get_value(words_, first_address_, options_.profile, rate) <= 0.0) return cia402::kParameterFault;
    }
    if (!is_homed_) return cia402::kNotHomedFault;
    if (!options_.tool.limits.contains(target)) return cia402::kLimitFault;
    if (armed == Armed::closing && tool_.is_probe_closed()) return cia402::kProbeClosedFault;
    return cia402::kNoFault;
}

void VirtualModbusController::start() {
    // Without an echo: the command was not taken.
    if ((drive_state_ & cia402::kOperationEnabled) == 0 || suffers(MachineFault::ignored_command)) return;
    sequence_ = told(F::sequence);
    silence_ = Seconds(0);
    stored_ = 0;
    const std::uint16_t function = told(F::touch_probe_function);
    const bool is_enabled = (function & cia402::kProbeEnable) != 0;
    armed_ = is_enabled && (function & cia402::kProbePositiveEdge) != 0   ? Armed::closing
             : is_enabled && (function & cia402::kProbeNegativeEdge) != 0 ? Armed::opening
                                                                          : Armed::nothing;
    const Point target = told_target();
    if (const std::uint16_t code = objection(target, armed_); code != cia402::kNoFault) return fail(code);
    if (suffers(MachineFault::missed_trigger)) tool_.miss_next_trigger();
    const double slowness = suffers(MachineFault::crawl) ? 0.001 : 1.0;
    const auto guard = told(F::stop_on_touch) == 0 || armed_ == Armed::nothing ? VirtualTool::Guard::none
                       : armed_ == Armed::closing                              ? VirtualTool::Guard::until_contact
                                                                               : VirtualTool::Guard::until_release;
    direction_ = (target - tool_.position()).stableNormalized();
    tool_.start_move(target, slowness * get_value(words_, first_address_, options_.profile, F::velocity), guard);
}

void VirtualModbusController::fail(std::uint16_t code) {
    fault_code_ = code;
    drive_state_ = bits(cia402::kFault | cia402::kVoltageEnabled | cia402::kQuickStopInactive);
    if (code == cia402::kLimitFault) drive_state_ |= cia402::kInternalLimit;
    if (tool_.is_moving()) tool_.decelerate();
}

void VirtualModbusController::latch() {
    const std::optional<Point> trigger = tool_.trigger();
    if (!trigger || stored_ != 0 || armed_ == Armed::nothing) return;
    if (armed_ == Armed::closing) {
        const bool is_silent = suffers(MachineFault::missed_edge_in_silence);
        if (is_silent) fail(cia402::kHeartbeatFault);
        if (is_silent || suffers(MachineFault::missed_edge)) {
            armed_ = Armed::nothing;
            return;
        }
        stored_ = cia402::kPositiveEdgeStored;
        edges_ = bits(edges_ + (suffers(MachineFault::repeated_edge) ? 2U : 1U));
        if (fault_ >= MachineFault::zero_position && fault_ <= MachineFault::shifted_beside && !is_false_) {
            is_false_ = true;
            position_at_contact_ = tool_.position();
        }
        if (suffers(MachineFault::stale_latch)) return;
    } else {
        stored_ = cia402::kNegativeEdgeStored;
    }
    latched_ = *trigger + latch_shift_ * direction_;
}

void VirtualModbusController::advance(Seconds time) {
    if (options_.scan.count() <= 0.0) return pass(time);
    while (time.count() > 0.0) {
        const Seconds step = std::min(time, options_.scan - since_scan_);
        pass(step);
        time -= step;
        since_scan_ += step;
        if (since_scan_ < options_.scan) continue;
        since_scan_ = Seconds(0);
        for (const auto& [address, words] : std::exchange(inbox_, {})) take(address, words);
        show();
        image_ = words_;
    }
}

void VirtualModbusController::pass(Seconds time) {
    if (!tool_.is_moving()) return tool_.advance(time * options_.speedup);
    if (armed_ == Armed::closing && suffers(MachineFault::spurious_trigger)) tool_.trigger_spuriously();
    if (suffers(MachineFault::limit)) fail(cia402::kLimitFault);
    if (suffers(MachineFault::homing_lost)) is_homed_ = false;
    // Where the silence becomes too long within this time, the axes slow down from there on.
    const Seconds heard = std::clamp(options_.profile.heartbeat_limit - silence_, Seconds(0), time);
    tool_.advance(heard * options_.speedup);
    latch();
    silence_ += time;
    if (!tool_.is_moving() || silence_ < options_.profile.heartbeat_limit) return;
    if (fault_code_ == cia402::kNoFault) {
        ++heartbeat_stops_;
        fail(cia402::kHeartbeatFault);
    }
    tool_.advance((time - heard) * options_.speedup);
    latch();
}

void VirtualModbusController::mend() {
    fault_.reset();
    is_false_ = false;
}

void VirtualModbusController::disable() {
    drive_state_ = kDisabled;
    if (tool_.is_moving()) tool_.decelerate();
}

void VirtualModbusController::press_emergency_stop() { fail(cia402::kExternalFault); }

void VirtualModbusController::quick_stop() {
    drive_state_ = bits(drive_state_ & ~static_cast<unsigned>(cia402::kQuickStopInactive));
    if (tool_.is_moving()) tool_.decelerate();
}

void VirtualModbusController::freeze() {
    is_frozen_ = true;
    if (tool_.is_moving()) tool_.decelerate();
}

void VirtualModbusController::home() {
    tool_.place(tool_.true_position());
    is_homed_ = true;
}

void VirtualModbusController::reset() {
    tool_.abort();
    std::ranges::fill(words_, std::uint16_t{0});
    is_homed_ = is_frozen_ = false;
    drive_state_ = kDisabled;
    control_word_ = fault_code_ = sequence_ = heartbeat_ = stored_ = edges_ = 0;
    armed_ = Armed::nothing;
    latched_ = Point::Zero();
    inbox_.clear();
    mend();
}

void VirtualModbusController::put(F field, double value) { put_value(words_, first_address_, options_.profile, field, value); }

void VirtualModbusController::swap_words() {
    for (const F x : {F::actual_x, F::latched_x}) {
        for (int axis = 0; axis < 3; ++axis) {
            const ModbusRegister& entry = options_.profile[axis_of(x, axis)];
            const auto at = static_cast<std::size_t>(entry.address - first_address_);
            if (entry.bits == 32) std::swap(words_[at], words_[at + 1]);
        }
    }
}

void VirtualModbusController::put(F x, const Point& p) {
    for (int axis = 0; axis < 3; ++axis) put(axis_of(x, axis), p[axis]);
}

// What it says of where it is.
Point VirtualModbusController::told_position() const {
    constexpr double kShift = 30.0;  // mm
    const Point position = tool_.position();
    if (!is_false_ || !fault_) return position;
    switch (*fault_) {
        case MachineFault::zero_position:
            return Point::Zero();
        case MachineFault::frozen_position:
            return position_at_contact_;
        case MachineFault::shifted_along:
            return position - kShift * Vector::UnitX();
        case MachineFault::shifted_beside:
            return position + kShift * Vector::UnitY();
        default:
            return position;
    }
}

std::span<const std::uint16_t> VirtualModbusController::registers() {
    if (options_.scan.count() > 0.0 && !image_.empty()) return image_;
    show();
    return words_;
}

void VirtualModbusController::show() {
    const ModbusProfile& profile = options_.profile;
    if (!is_frozen_) {
        const unsigned homed = is_homed_ ? 1U << static_cast<unsigned>(profile.homed_bit) : 0U;
        const bool is_stuck = fault_ == MachineFault::stuck_probe && stored_ != 0;
        const unsigned closed = tool_.is_probe_closed() || is_stuck ? 1U << static_cast<unsigned>(profile.probe_closed_bit) : 0U;
        put(F::status_word, bits(drive_state_ | homed | (tool_.is_moving() ? 0U : cia402::kStanding)));
        put(F::fault_code, fault_code_);
        put(F::actual_x, told_position());
        put(F::touch_probe_status, bits(stored_ | closed | (armed_ == Armed::nothing ? 0U : cia402::kProbeEnabled)));
        put(F::edge_counter, edges_);
        put(F::latched_x, latched_);
        if (is_false_ && fault_ == MachineFault::swapped_words) swap_words();
        put(F::sequence_echo, sequence_);
        put(F::heartbeat_echo, heartbeat_);
    }
    put(F::min_x, options_.tool.limits.min);
    constexpr double kWobble = 0.01;  // mm
    if (fault_ == MachineFault::unsteady_limits) ++looks_;
    put(F::max_x, options_.tool.limits.max + Vector::Constant(kWobble * looks_));
    std::ranges::copy(registers_of_text(options_.identity, profile.identity.registers),
                      words_.begin() + (profile.identity.address - first_address_));
}

}  // namespace palpate
