#include "devices/modbus/modbus_link.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <modbus/modbus.h>
#include <netdb.h>
#include <sys/socket.h>
#include <sys/types.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <optional>
#include <utility>

#include "devices/errors.h"
#include "devices/posix/machine_lock.h"
#include "devices/posix/serial_port.h"

namespace palpate {
namespace {

struct FreeContext {
    void operator()(modbus_t* context) const {
        modbus_close(context);
        modbus_free(context);
    }
};
using Context = std::unique_ptr<modbus_t, FreeContext>;

// Registers as frames carry them: "001F 0001 1170".
std::string hex_text(std::span<const std::uint16_t> words) { return fmt::format("{:04X}", fmt::join(words, " ")); }

std::string request_text(const char* what, int address, std::size_t registers) {
    return fmt::format("{} of registers {} to {}", what, address, address + static_cast<int>(registers) - 1);
}

// The numbers that numeric hosts stand for, so that one machine has one name.
std::vector<std::string> addresses_of(const ModbusTcp& tcp) {
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    if (const int error = ::getaddrinfo(tcp.host.c_str(), nullptr, &hints, &found); error != 0) {
        throw ConnectionLost(fmt::format("cannot find the host \"{}\": {}; is the name right?", tcp.host, ::gai_strerror(error)));
    }
    const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(found, &::freeaddrinfo);
    std::vector<std::string> numbers;
    for (const addrinfo* entry = found; entry != nullptr; entry = entry->ai_next) {
        std::array<char, NI_MAXHOST> number{};
        if (::getnameinfo(entry->ai_addr, entry->ai_addrlen, number.data(), number.size(), nullptr, 0, NI_NUMERICHOST) == 0) {
            numbers.emplace_back(number.data());
        }
    }
    return numbers;
}

void check_options(const ModbusLinkOptions& options) {
    const auto refuse = [](const std::string& what) { throw DeviceError(fmt::format("Modbus link: {}", what)); };
    const auto* tcp = std::get_if<ModbusTcp>(&options.where);
    const bool unit_is_known = (options.unit >= 0 && options.unit <= 247) || (tcp != nullptr && options.unit == MODBUS_TCP_SLAVE);
    if (!unit_is_known) refuse(fmt::format("unit {}; allowed: 0 to 247, on TCP 255 too", options.unit));
    if (tcp != nullptr && (tcp->port < 1 || tcp->port > 65535)) refuse(fmt::format("port {}; allowed: 1 to 65535", tcp->port));
    if (const auto* rtu = std::get_if<ModbusRtu>(&options.where)) {
        // libmodbus would take 9600 for one that it does not know.
        if (!is_serial_speed(rtu->baud)) refuse(fmt::format("baud {}; allowed: {}", rtu->baud, serial_speeds()));
        if (rtu->parity != 'N' && rtu->parity != 'E' && rtu->parity != 'O') refuse("parity; allowed: N, E, O");
        if (rtu->stop_bits != 1 && rtu->stop_bits != 2) refuse("stop bits; allowed: 1, 2");
    }
    if (!(options.answer_timeout.count() > 0.0) || options.slowest_answer < options.answer_timeout) {
        refuse("the slowest answer comes before the time to wait for one is over; allowed: 0 < answer_timeout <= slowest_answer");
    }
    if (options.reconnects < 0) refuse("a negative number of reconnects");
    if (options.reconnect_time < Seconds(0) || options.busy_time < Seconds(0)) refuse("a negative time");
}

// Between frames: 3.5 characters of 11 bits, above 19200 baud 1.75 ms (Modbus over serial line 1.02, 2.5.1.1). On TCP nothing.
Seconds frame_gap(const ModbusLinkOptions& options) {
    const auto* rtu = std::get_if<ModbusRtu>(&options.where);
    return rtu == nullptr ? Seconds(0) : std::max(Seconds(0.00175), Seconds(3.5 * 11 / rtu->baud));
}

}  // namespace

struct ModbusLink::Connection {
    MachineLock lock;  // taken first, given back last
    Context context;
};

ModbusLink::ModbusLink(ModbusLinkOptions options, Clock& clock) : options_(std::move(options)), clock_(clock) {
    check_options(options_);
    connect();
}

ModbusLink::~ModbusLink() = default;

void ModbusLink::connect() {
    connection_.reset();
    const auto open = [&](MachineLock lock, modbus_t* made) -> bool {
        auto next = std::make_unique<Connection>(Connection{std::move(lock), Context(made)});
        if (made == nullptr) return false;
        const auto micros = std::chrono::duration_cast<std::chrono::microseconds>(options_.answer_timeout).count();
        modbus_set_response_timeout(made, static_cast<std::uint32_t>(micros / 1000000), static_cast<std::uint32_t>(micros % 1000000));
        modbus_set_error_recovery(made, MODBUS_ERROR_RECOVERY_NONE);
        if (modbus_set_slave(made, options_.unit) != 0 || modbus_connect(made) != 0) return false;
        modbus_flush(made);  // what an earlier run left in the line
        connection_ = std::move(next);
        return true;
    };
    int error = 0;
    if (const auto* rtu = std::get_if<ModbusRtu>(&options_.where)) {
        MachineLock lock = MachineLock::of_device(rtu->path);
        if (open(std::move(lock), modbus_new_rtu(rtu->path.c_str(), rtu->baud, rtu->parity, 8, rtu->stop_bits))) return;
        error = errno;
    } else {
        const auto& tcp = std::get<ModbusTcp>(options_.where);
        for (const std::string& number : addresses_of(tcp)) {
            MachineLock lock = MachineLock::of_peer(number, tcp.port);
            if (open(std::move(lock), modbus_new_tcp_pi(number.c_str(), std::to_string(tcp.port).c_str()))) return;
            error = errno;
        }
    }
    throw ConnectionLost(fmt::format("cannot connect to {}: {}; is the controller on, is the address right, and may you use it?", name(),
                                     modbus_strerror(error)));
}

void ModbusLink::reconnect(const StopToken& stop) {
    connection_.reset();
    const auto give_up_at = clock_.now() + to_nanoseconds(options_.reconnect_time);
    for (int attempt = 1;; ++attempt) {
        try {
            return connect();
        } catch (const ConnectionLost& error) {
            if (clock_.now() >= give_up_at || stop.stop_requested()) {
                throw ConnectionLost(fmt::format("{} (given up after {} attempts)", error.what(), attempt));
            }
        }
        clock_.sleep(to_nanoseconds(options_.reconnect_pause));
    }
}

std::string ModbusLink::name() const {
    if (const auto* rtu = std::get_if<ModbusRtu>(&options_.where)) return fmt::format("unit {} at {}", options_.unit, rtu->path);
    const auto& tcp = std::get<ModbusTcp>(options_.where);
    return fmt::format("unit {} at {}:{}", options_.unit, tcp.host, tcp.port);
}

std::string ModbusLink::last_exchange() const { return fmt::format("last request: {}; answer: {}", request_, answer_); }

// Leaves the line alone until no answer can come any more, and drops what came.
void ModbusLink::settle(std::chrono::nanoseconds asked_at) {
    const auto quiet_at = asked_at + to_nanoseconds(options_.slowest_answer);
    if (const auto now = clock_.now(); now < quiet_at) clock_.sleep(quiet_at - now);
    modbus_flush(connection_->context.get());
}

void ModbusLink::wait_for_gap() {
    if (const auto now = clock_.now(); now < free_at_) clock_.sleep(free_at_ - now);
}

void ModbusLink::lose(int error) {
    connection_.reset();
    answer_ = modbus_strerror(error);
    throw ConnectionLost(
        fmt::format("lost the connection to {}: {}; {}; look at cable and power, then connect again", name(), answer_, last_exchange()));
}

void ModbusLink::fail(int error, std::chrono::nanoseconds asked_at) {
    if (error == ETIMEDOUT) {
        settle(asked_at);
        answer_ = fmt::format("none within {:f} s", options_.answer_timeout.count());
        throw DeviceTimeout(fmt::format(
            "no answer from {}; {}; is the controller on, and does it have this unit number{} (A unit that nobody has is silent; an "
            "address that nobody has is an exception.)",
            name(), last_exchange(),
            std::holds_alternative<ModbusRtu>(options_.where) ? ", do speed and parity match, and are the two wires the right way round?"
                                                              : ", or is that a gateway which does not reach it?"));
    }
    if (error > MODBUS_ENOBASE && error <= EMBXGTAR) {
        const int code = error - MODBUS_ENOBASE;
        answer_ = fmt::format("exception {} ({})", code, modbus_strerror(error));
        const char* const hint = error == EMBXILADD ? "; it has no such registers: does the profile fit the controller?"
                                 : error == EMBXGTAR || error == EMBXGPATH ? "; the gateway does not reach that unit: is its number right?"
                                                                           : "";
        throw DeviceRefused(code, fmt::format("{} refused: {}{}", name(), last_exchange(), hint));
    }
    if (error >= EMBBADCRC && error <= EMBBADSLAVE) {
        settle(asked_at);
        answer_ = modbus_strerror(error);
        const char* const hint = error == EMBBADSLAVE ? "; another unit answered: do two have the same number?" : "";
        throw BadAnswer(fmt::format("what {} sent is no answer: {}{}", name(), last_exchange(), hint));
    }
    lose(error);
}

template <class Call>
void ModbusLink::exchange(const std::string& request, const Call& call) {
    if (!connection_) throw ConnectionLost(fmt::format("not connected to {}; connect again", name()));
    wait_for_gap();
    request_ = request;
    answer_ = "none yet";
    const auto asked_at = clock_.now();
    errno = 0;
    const int result = call(connection_->context.get());
    const int error = errno;
    free_at_ = clock_.now() + to_nanoseconds(frame_gap(options_));
    if (result < 0) fail(error, asked_at);
}

std::vector<std::uint16_t> ModbusLink::read(int address, int registers) {
    std::vector<std::uint16_t> words(static_cast<std::size_t>(registers));
    exchange(request_text("read (FC03)", address, words.size()),
             [&](modbus_t* context) { return modbus_read_registers(context, address, registers, words.data()); });
    answer_ = hex_text(words);
    return words;
}

std::vector<std::uint16_t> ModbusLink::write_and_read(int write_address, std::span<const std::uint16_t> words, int address, int registers) {
    std::vector<std::uint16_t> answer(static_cast<std::size_t>(registers));
    exchange(fmt::format("{} with {} and {}", request_text("write", write_address, words.size()), hex_text(words),
                         request_text("read (FC23)", address, answer.size())),
             [&](modbus_t* context) {
                 return modbus_write_and_read_registers(context, write_address, static_cast<int>(words.size()), words.data(), address,
                                                        registers, answer.data());
             });
    answer_ = hex_text(answer);
    return answer;
}

void ModbusLink::write(int address, std::span<const std::uint16_t> words) {
    exchange(fmt::format("{} with {}", request_text("write (FC16)", address, words.size()), hex_text(words)),
             [&](modbus_t* context) { return modbus_write_registers(context, address, static_cast<int>(words.size()), words.data()); });
    answer_ = "accepted";
}

}  // namespace palpate
