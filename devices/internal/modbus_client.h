// What a Modbus controller is asked and told, in our words: status, limits, commands. No waiting for motion here.
#pragma once

#include <cstdint>
#include <string>

#include "devices/modbus_bits.h"
#include "devices/modbus_link.h"
#include "devices/modbus_profile.h"
#include "planner/geometry.h"
#include "planner/workspace.h"

namespace palpate {

// The status block as it was at one moment. Positions are machine coordinates in mm.
struct ModbusStatus {
    std::uint16_t status_word = 0;
    std::uint16_t fault_code = 0;
    std::uint16_t touch_status = 0;
    std::uint16_t edges = 0;
    std::uint16_t sequence = 0;
    std::uint16_t heartbeat = 0;
    bool is_homed = false;
    bool is_probe_closed = false;
    Point actual = Point::Zero();
    Point latched = Point::Zero();

    [[nodiscard]] bool has(std::uint16_t bits) const { return (status_word & bits) == bits; }
    [[nodiscard]] bool is_standing() const { return has(cia402::kStanding); }
    [[nodiscard]] bool is_fault() const { return has(cia402::kFault); }
};

enum class ProbeEdge { closing, opening };

struct ModbusCommand {
    Point target = Point::Zero();  // mm, machine coordinates
    double feed_mm_per_s = 0.0;
    double acceleration_mm_per_s2 = 0.0;
    ProbeEdge edge = ProbeEdge::closing;  // that ends it
    std::uint16_t sequence = 0;
};

// Repeats what may be repeated when an answer is lost. What its calls throw: see ModbusLink.
class ModbusClient {
public:
    // Throws std::invalid_argument on a profile that check_profile refuses, and as ModbusLink does.
    ModbusClient(const ModbusLinkOptions& link, ModbusProfile profile, Clock& clock);

    // Sends a heartbeat and reads the status block. It is the answer to that heartbeat: a block that echoes another is late, and is
    // read again; DeviceTimeout if the echo does not come.
    [[nodiscard]] ModbusStatus status();
    [[nodiscard]] std::string identity();
    // Read twice: two equal answers in a row, with another kind of request between them, are no late ones.
    [[nodiscard]] Box limits();

    // Sends the command block in one frame. If its answer is lost, the echo tells whether it arrived; it is sent again with the same
    // number, which starts nothing twice.
    void start(const ModbusCommand& command);
    void halt();
    void reset_fault();
    void enable();

    [[nodiscard]] std::uint64_t lost_answers() const { return lost_answers_; }
    [[nodiscard]] ModbusLink& link() { return link_; }
    [[nodiscard]] const ModbusLink& link() const { return link_; }
    [[nodiscard]] const ModbusProfile& profile() const { return profile_; }

private:
    // Runs `call` again after silence or garbage, a few times.
    template <class Call>
    auto repeating(const Call& call);
    [[nodiscard]] ModbusStatus read_status();
    [[nodiscard]] Box read_limits();
    void write_control(std::uint16_t word);

    ModbusProfile profile_;
    Clock& clock_;
    ModbusLink link_;
    ModbusSpan command_;
    ModbusSpan status_;
    ModbusSpan limits_;
    std::uint16_t heartbeat_ = 0;
    std::uint64_t lost_answers_ = 0;
};

}  // namespace palpate
