// The program of a virtual Modbus controller: registers on one side, a virtual tool on the other. No sockets, no threads, no clock.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "devices/modbus/modbus_profile.h"
#include "sim/machines/virtual_tool.h"

namespace palpate {

struct VirtualModbusOptions {
    ModbusProfile profile = ModbusProfile::standard();
    VirtualToolOptions tool;
    std::string identity = "palpate virtual probe 1";
    bool homed = true;
    double speedup = 1.0;  // the tool's time runs so much faster than ours; the heartbeat is watched in ours
    Seconds scan{0};       // it takes what was written, and shows what is, so often; 0: at once
};

// What goes wrong in the machine.
enum class MachineFault : std::uint8_t {
    // Once, at the next touch:
    missed_edge,             // the tool stops, but nothing is latched
    missed_edge_in_silence,  // the same, and it says that it stopped because the host was silent
    repeated_edge,           // one more edge is counted than there was
    stale_latch,             // the latch is still the one before
    missed_trigger,          // the probe does not close
    // Once, in the next move:
    spurious_trigger,  // the probe closes for a moment where nothing is
    limit,             // the limit switch is met on the way
    homing_lost,       // it is not homed any more, and goes on
    ignored_command,   // is not taken
    crawl,             // goes at a thousandth of its velocity
    ignored_halt,      // is not stopped by the first halt
    // From the next contact until mend():
    zero_position,    // the actual position reads 0
    swapped_words,    // of actual and latched positions
    frozen_position,  // the actual position stands still
    shifted_along,    // the actual position is told 30 mm off, towards lesser x
    shifted_beside,   // the same, towards greater y
    // Until mend():
    stuck_probe,      // after a touch it reads closed for ever
    unsteady_limits,  // are others at each look
};

class VirtualModbusController {
public:
    // `obstacle` must outlive it. Throws std::invalid_argument on a false profile, and if the limits or the start do not fit its registers.
    VirtualModbusController(const Obstacle& obstacle, const VirtualModbusOptions& options);

    // Nothing if the registers can be read, written; otherwise the number of a Modbus exception: 2 where a register is none of the
    // profile's, or not the host's to write, 6 for a command while the axes move.
    [[nodiscard]] std::optional<int> refuses_to_read(int address, int registers) const;
    [[nodiscard]] std::optional<int> refuses_to_write(int address, int registers) const;
    // REQUIRES: not refused.
    void write(int address, std::span<const std::uint16_t> words);
    // All registers from first_address() on, as they are now.
    [[nodiscard]] std::span<const std::uint16_t> registers();
    [[nodiscard]] int first_address() const { return first_address_; }
    [[nodiscard]] const ModbusProfile& profile() const { return options_.profile; }

    void advance(Seconds time);

    void inject(MachineFault fault) { fault_ = fault; }
    void mend();
    // Latches are told so many mm farther along the way than they are.
    void shift_latches(double mm) { latch_shift_ = mm; }
    // The axes slow down: the drives are disabled, an emergency stop is pressed, a quick stop.
    void disable();
    void press_emergency_stop();
    void quick_stop();
    // The program stands still, as if its cycle had crashed, while registers still answer; its watchdog stops the axes.
    void freeze();
    // Power off and on: the axes stop dead, the position is lost, all is forgotten.
    void reset();
    // The count of steps is right from here on. REQUIRES: not moving.
    void home();

    [[nodiscard]] const VirtualTool& tool() const { return tool_; }
    [[nodiscard]] VirtualTool& tool() { return tool_; }
    [[nodiscard]] std::uint64_t heartbeat_stops() const { return heartbeat_stops_; }
    // Writes of the control word or of the whole command.
    [[nodiscard]] std::uint64_t commands() const { return commands_; }
    // New commands that came with a rising edge of the set-point bit, and without.
    [[nodiscard]] std::uint64_t set_points() const { return set_points_; }
    [[nodiscard]] std::uint64_t commands_without_edge() const { return commands_without_edge_; }

private:
    enum class Armed : std::uint8_t { nothing, closing, opening };

    [[nodiscard]] bool holds(ModbusField field, int address, int registers) const;
    [[nodiscard]] std::uint16_t told(ModbusField field) const;
    [[nodiscard]] Point told_target() const;
    void take(int address, std::span<const std::uint16_t> words);
    void control(std::uint16_t word);
    void start();
    void pass(Seconds time);
    void show();
    void swap_words();
    [[nodiscard]] Point told_position() const;
    [[nodiscard]] std::uint16_t objection(const Point& target, Armed armed) const;
    void fail(std::uint16_t code);
    // Whether that fault is due; it is over then.
    [[nodiscard]] bool suffers(MachineFault fault);
    void latch();
    void put(ModbusField field, double value);
    void put(ModbusField x, const Point& p);

    VirtualModbusOptions options_;
    VirtualTool tool_;
    int first_address_ = 0;
    std::vector<bool> known_;           // by address: the profile has it
    std::vector<std::uint16_t> words_;  // by address
    bool is_homed_ = true;
    bool is_frozen_ = false;
    std::uint16_t drive_state_;  // the CiA 402 bits of the status word
    std::uint16_t control_word_ = 0;
    std::uint16_t fault_code_ = 0;
    std::uint16_t sequence_ = 0;
    std::uint16_t heartbeat_ = 0;
    Seconds silence_{0};  // since the heartbeat changed
    std::uint64_t heartbeat_stops_ = 0;
    Armed armed_ = Armed::nothing;
    std::uint16_t stored_ = 0;  // bits of the touch-probe status
    std::uint16_t edges_ = 0;
    Point latched_ = Point::Zero();
    std::optional<MachineFault> fault_{};
    int looks_ = 0;          // at limits that are unsteady
    bool is_false_ = false;  // its positions are, since a contact
    Point position_at_contact_ = Point::Zero();
    Vector direction_ = Vector::Zero();  // of the last command
    double latch_shift_ = 0.0;
    std::uint64_t commands_ = 0;
    std::uint64_t set_points_ = 0;
    std::uint64_t commands_without_edge_ = 0;
    Seconds since_scan_{0};
    std::vector<std::pair<int, std::vector<std::uint16_t>>> inbox_{};  // not yet taken
    std::vector<std::uint16_t> image_{};                               // what is shown
};

}  // namespace palpate
