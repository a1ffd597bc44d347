// What a Modbus controller is asked and told, in our words: status, limits, commands. No waiting for motion here.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "devices/modbus/modbus_bits.h"
#include "devices/modbus/modbus_link.h"
#include "devices/modbus/modbus_profile.h"
#include "planner/geometry.h"
#include "planner/region.h"

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
    // Finds out whether a heartbeat and the status fit in one request. Throws std::invalid_argument on a profile that check_profile
    // refuses, and as ModbusLink does.
    ModbusClient(const ModbusLinkOptions& link, ModbusProfile profile, Clock& clock);

    // Sends heartbeats and reads the status block until it echoes one of them, so that it is no answer to an earlier question. Throws
    // BadAnswer if no echo comes.
    [[nodiscard]] ModbusStatus status();
    // The same without waiting for the echo: how long it took, by the clock.
    Seconds look();
    // What the last look took, without waiting for the echo; requests in one.
    [[nodiscard]] Seconds look_time() const { return look_time_; }
    [[nodiscard]] int look_requests() const { return is_combined_ ? 1 : 2; }
    [[nodiscard]] std::string identity();
    // Read twice: two equal answers in a row, with another kind of request between them, are no late ones.
    [[nodiscard]] Box limits();

    // Sends the command block in one frame. If its answer is lost, the echo tells whether it arrived; it is sent again with the same
    // number, which starts nothing twice.
    void start(const ModbusCommand& command);
    // Until it is heard, for so long. Throws as any request, and says that the machine may still move.
    void halt(Seconds limit);
    // The control word without the set-point bit.
    void take_back_set_point();
    void reset_fault();
    // Waits for each state on the way, for as long as an echo may take. A controller that does not show one is told the next all the same.
    void enable();

    [[nodiscard]] std::uint64_t lost_answers() const { return lost_answers_; }
    [[nodiscard]] ModbusLink& link() { return link_; }
    [[nodiscard]] const ModbusLink& link() const { return link_; }
    [[nodiscard]] const ModbusProfile& profile() const { return profile_; }

private:
    // Runs `call` again after silence or garbage, a few times, and for `busy` where the unit is busy or not reached.
    template <class Call>
    auto repeating(const Call& call, Seconds busy);
    template <class Call>
    auto repeating(const Call& call);
    [[nodiscard]] bool finds_read_write();
    [[nodiscard]] ModbusStatus beat_and_read();
    [[nodiscard]] ModbusStatus status_of(const std::vector<std::uint16_t>& words) const;
    void wait_for(std::uint16_t state);
    [[nodiscard]] Box read_limits();
    void write_control(std::uint16_t word);

    ModbusProfile profile_;
    Clock& clock_;
    ModbusLink link_;
    ModbusSpan command_;
    ModbusSpan status_;
    ModbusSpan limits_;
    bool is_combined_ = false;
    Seconds look_time_{0};
    std::uint16_t heartbeat_ = 0;
    std::uint64_t lost_answers_ = 0;
};

}  // namespace palpate
