#include "devices/internal/modbus_client.h"

#include <array>
#include <chrono>
#include <utility>
#include <vector>

#include "devices/errors.h"

namespace palpate {
namespace {

// How often a request is sent again after its answer was lost.
constexpr int kRepeats = 2;
// A controller that works in cycles echoes in its next one; 20 ms are a slow cycle.
constexpr int kEchoReads = 8;
constexpr std::chrono::milliseconds kEchoPause{5};

ModbusProfile checked(ModbusProfile profile) {
    check_profile(profile);
    return profile;
}

}  // namespace

ModbusClient::ModbusClient(const ModbusLinkOptions& link, ModbusProfile profile, Clock& clock)
    : profile_(checked(std::move(profile))),
      clock_(clock),
      link_(link, clock),
      command_(span_of(profile_, ModbusBlock::command)),
      status_(span_of(profile_, ModbusBlock::status)),
      limits_(span_of(profile_, ModbusBlock::limits)) {}

template <class Call>
auto ModbusClient::repeating(const Call& call) {
    for (int attempt = 0;; ++attempt) {
        try {
            return call();
        } catch (const DeviceTimeout&) {
            if (attempt == kRepeats) throw;
        } catch (const BadAnswer&) {
            if (attempt == kRepeats) throw;
        }
        ++lost_answers_;
    }
}

ModbusStatus ModbusClient::read_status() {
    const std::vector<std::uint16_t> words = link_.read(status_.address, status_.registers);
    const auto word = [&](ModbusField field) { return get_word(words, status_.address, profile_, field); };
    ModbusStatus status;
    status.status_word = word(ModbusField::status_word);
    status.fault_code = word(ModbusField::fault_code);
    status.touch_status = word(ModbusField::touch_probe_status);
    status.edges = word(ModbusField::edge_counter);
    status.sequence = word(ModbusField::sequence_echo);
    status.heartbeat = word(ModbusField::heartbeat_echo);
    status.is_homed = ((static_cast<unsigned>(status.status_word) >> static_cast<unsigned>(profile_.homed_bit)) & 1U) != 0;
    status.is_probe_closed = ((static_cast<unsigned>(status.touch_status) >> static_cast<unsigned>(profile_.probe_closed_bit)) & 1U) != 0;
    for (int axis = 0; axis < 3; ++axis) {
        status.actual[axis] = get_value(words, status_.address, profile_, axis_of(ModbusField::actual_x, axis));
        status.latched[axis] = get_value(words, status_.address, profile_, axis_of(ModbusField::latched_x, axis));
    }
    return status;
}

ModbusStatus ModbusClient::status() {
    return repeating([&] {
        const std::array beat{++heartbeat_};
        link_.write(profile_[ModbusField::heartbeat].address, beat);
        for (int read = 0; read < kEchoReads; ++read) {
            if (read > 0) clock_.sleep(kEchoPause);
            if (ModbusStatus status = read_status(); status.heartbeat == heartbeat_) return status;
        }
        throw DeviceTimeout("waited for " + link_.name() + " to echo the heartbeat " + std::to_string(heartbeat_) +
                            ": it answers, but its program stands still or does not know the profile " + profile_.name + "; " +
                            link_.last_exchange());
    });
}

std::string ModbusClient::identity() {
    return repeating([&] { return text_of_registers(link_.read(profile_.identity.address, profile_.identity.registers)); });
}

Box ModbusClient::read_limits() {
    const std::vector<std::uint16_t> words = repeating([&] { return link_.read(limits_.address, limits_.registers); });
    Box limits;
    for (int axis = 0; axis < 3; ++axis) {
        limits.min[axis] = get_value(words, limits_.address, profile_, axis_of(ModbusField::min_x, axis));
        limits.max[axis] = get_value(words, limits_.address, profile_, axis_of(ModbusField::max_x, axis));
    }
    return limits;
}

Box ModbusClient::limits() {
    Box limits = read_limits();
    for (int read = 0; read <= kRepeats; ++read) {
        (void)status();
        const Box again = read_limits();
        if (again.min == limits.min && again.max == limits.max) return limits;
        limits = again;
    }
    throw BadAnswer(link_.name() + " tells other limits each time; " + link_.last_exchange());
}

void ModbusClient::start(const ModbusCommand& command) {
    using F = ModbusField;
    std::vector<std::uint16_t> words(static_cast<std::size_t>(command_.registers), 0);
    const auto put = [&](F field, double value) { put_value(words, command_.address, profile_, field, value); };
    put(F::control_word, cia402::kEnableOperation | cia402::kNewSetPoint);
    for (int axis = 0; axis < 3; ++axis) put(axis_of(F::target_x, axis), command.target[axis]);
    put(F::velocity, command.feed_mm_per_s);
    put(F::acceleration, command.acceleration_mm_per_s2);
    put(F::touch_probe_function,
        cia402::kProbeEnable | (command.edge == ProbeEdge::closing ? cia402::kProbePositiveEdge : cia402::kProbeNegativeEdge));
    put(F::stop_on_touch, 1);
    put(F::sequence, command.sequence);
    bool sent = false;
    repeating([&] {
        if (sent && status().sequence == command.sequence) return;
        sent = true;
        link_.write(command_.address, words);
    });
}

void ModbusClient::write_control(std::uint16_t word) {
    const std::array words{word};
    repeating([&] { link_.write(profile_[ModbusField::control_word].address, words); });
}

void ModbusClient::halt() { write_control(cia402::kEnableOperation | cia402::kHalt); }

void ModbusClient::reset_fault() {
    write_control(0);  // the reset is the rising edge of its bit
    write_control(cia402::kFaultReset);
    enable();
}

void ModbusClient::enable() {
    write_control(cia402::kShutdown);
    write_control(cia402::kSwitchOn);
    write_control(cia402::kEnableOperation);
}

}  // namespace palpate
