#include "devices/modbus/internal/modbus_client.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>
#include <vector>

#include "devices/clock.h"
#include "devices/errors.h"

namespace palpate {
namespace {

// How often a request is sent again after its answer was lost.
constexpr int kRepeats = 2;
// Between looks that wait for an echo.
constexpr std::chrono::milliseconds kEchoPause{5};
// Between requests to a unit that is busy.
constexpr std::chrono::milliseconds kBusyPause{20};
// Modbus application protocol 7: acknowledged, busy, the gateway's target does not answer.
constexpr std::array kPassing{5, 6, 11};

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
      limits_(span_of(profile_, ModbusBlock::limits)) {
    is_combined_ = profile_.read_write && finds_read_write();
}

template <class Call>
auto ModbusClient::repeating(const Call& call, Seconds busy) {
    const auto give_up_at = clock_.now() + to_nanoseconds(busy);
    bool was_busy = false;
    for (int attempt = 0;;) {
        try {
            return call();
        } catch (const DeviceRefused& refused) {
            if (std::ranges::find(kPassing, refused.code()) == kPassing.end() || clock_.now() >= give_up_at) throw;
            clock_.sleep(kBusyPause);
            if (std::exchange(was_busy, true)) continue;
        } catch (const DeviceTimeout&) {
            if (attempt++ == kRepeats) throw;
        } catch (const BadAnswer&) {
            if (attempt++ == kRepeats) throw;
        }
        ++lost_answers_;
    }
}

template <class Call>
auto ModbusClient::repeating(const Call& call) {
    return repeating(call, link_.options().busy_time);
}

ModbusStatus ModbusClient::status_of(const std::vector<std::uint16_t>& words) const {
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

// A controller that does not know the function says so, or is silent.
bool ModbusClient::finds_read_write() {
    is_combined_ = true;
    try {
        (void)repeating([&] { return beat_and_read(); });
    } catch (const ConnectionLost&) {
        throw;
    } catch (const DeviceError&) {
        return false;
    }
    return true;
}

ModbusStatus ModbusClient::beat_and_read() {
    const std::array beat{++heartbeat_};
    const int address = profile_[ModbusField::heartbeat].address;
    if (is_combined_) return status_of(link_.write_and_read(address, beat, status_.address, status_.registers));
    link_.write(address, beat);
    return status_of(link_.read(status_.address, status_.registers));
}

Seconds ModbusClient::look() {
    const auto asked_at = clock_.now();
    (void)repeating([&] { return beat_and_read(); });
    return clock_.now() - asked_at;
}

ModbusStatus ModbusClient::status() {
    const auto first = static_cast<std::uint16_t>(heartbeat_ + 1U);
    const auto after_first = [first](std::uint16_t beat) { return static_cast<std::uint16_t>(beat - first); };  // wraps
    const auto give_up_at = clock_.now() + to_nanoseconds(profile_.echo_limit);
    while (true) {
        const auto asked_at = clock_.now();
        ModbusStatus status = repeating([&] {
            const auto begun_at = clock_.now();
            ModbusStatus now = beat_and_read();
            look_time_ = clock_.now() - begun_at;
            return now;
        });
        if (after_first(status.heartbeat) <= after_first(heartbeat_)) return status;
        if (clock_.now() >= give_up_at) break;
        if (const auto next = asked_at + kEchoPause; clock_.now() < next) clock_.sleep(next - clock_.now());
    }
    throw BadAnswer(
        fmt::format("waited for {} to echo the heartbeat {}: it answers, but its program stands still or does not know the profile {}, or "
                    "it echoes later than echo_limit there; {}",
                    link_.name(), first, profile_.name, link_.last_exchange()));
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
    throw BadAnswer(fmt::format("{} tells other limits each time; {}", link_.name(), link_.last_exchange()));
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

void ModbusClient::halt(Seconds limit) {
    constexpr std::uint16_t kWord = cia402::kEnableOperation | cia402::kHalt;
    const auto give_up_at = clock_.now() + to_nanoseconds(limit);
    while (true) {
        try {
            return write_control(kWord);
        } catch (const ConnectionLost&) {
            throw;
        } catch (const DeviceError& error) {
            clock_.sleep(kBusyPause);
            if (clock_.now() < give_up_at) continue;
            throw DeviceTimeout(fmt::format(
                "a halt was not heard: {}; the machine may still move: use its own stop, and look where the tool is", error.what()));
        }
    }
}

void ModbusClient::take_back_set_point() { write_control(cia402::kEnableOperation); }

void ModbusClient::reset_fault() {
    // The reset is the rising edge of its bit, which a controller that looks once in a cycle has to see fallen: the look takes one.
    write_control(0);
    (void)status();
    write_control(cia402::kFaultReset);
    const auto give_up_at = clock_.now() + to_nanoseconds(profile_.echo_limit);
    while (status().is_fault() && clock_.now() < give_up_at) clock_.sleep(kEchoPause);
    enable();
}

void ModbusClient::wait_for(std::uint16_t state) {
    const auto give_up_at = clock_.now() + to_nanoseconds(profile_.echo_limit);
    while (!status().has(state) && clock_.now() < give_up_at) clock_.sleep(kEchoPause);
}

void ModbusClient::enable() {
    write_control(cia402::kShutdown);
    wait_for(cia402::kReadyToSwitchOn);
    write_control(cia402::kSwitchOn);
    wait_for(cia402::kSwitchedOn);
    write_control(cia402::kEnableOperation);
    wait_for(cia402::kOperationEnabled);
}

}  // namespace palpate
