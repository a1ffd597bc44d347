#include "sim/machines/modbus/virtual_modbus.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <modbus/modbus.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <exception>
#include <string_view>
#include <system_error>

#include "sim/machines/pseudo_terminal.h"

namespace palpate {
namespace {

// While the axes move, so often their state is looked at; the heartbeat is watched to this.
constexpr Seconds kMovingTick{0.002};
constexpr Seconds kIdleTick{0.02};
constexpr int kReadRegisters = 3;
constexpr int kWriteRegister = 6;
constexpr int kWriteRegisters = 16;
constexpr int kWriteAndReadRegisters = 23;
constexpr int kIllegalFunction = 1;
constexpr int kIllegalValue = 3;

[[noreturn]] void fail(const std::string& what) {
    throw std::system_error(errno, std::generic_category(), fmt::format("virtual Modbus machine: {}", what));
}

// A descriptor that is closed with its owner.
class Descriptor {
public:
    explicit Descriptor(int value = -1) : value_(value) {}
    ~Descriptor() {
        if (value_ >= 0) ::close(value_);
    }
    Descriptor(Descriptor&& other) noexcept : value_(std::exchange(other.value_, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        std::swap(value_, other.value_);
        return *this;
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    [[nodiscard]] int get() const { return value_; }

private:
    int value_;
};

struct FreeContext {
    void operator()(modbus_t* context) const { modbus_free(context); }
};
struct FreeMapping {
    void operator()(modbus_mapping_t* mapping) const { modbus_mapping_free(mapping); }
};

}  // namespace

struct VirtualModbus::Line {
    std::unique_ptr<modbus_t, FreeContext> context;
    Descriptor listener;                     // TCP
    std::vector<Descriptor> peers;           // TCP: one for each client
    std::optional<PseudoTerminal> terminal;  // otherwise
    Descriptor client_end;                   // of the terminal: held open, so that it outlives its clients
    Descriptor sink;                         // answers that get lost go here
    Descriptor sink_end;

    // They throw std::system_error, or ConnectionLost.
    void listen(VirtualModbusTcp& tcp);
    void open_terminal(const VirtualModbusSerial& serial);
    [[nodiscard]] std::string device() const { return terminal ? terminal->client_path() : ""; }
    static std::unique_ptr<Line> open(std::variant<VirtualModbusTcp, VirtualModbusSerial>& where, int unit);
};

void VirtualModbus::Line::listen(VirtualModbusTcp& tcp) {
    context.reset(modbus_new_tcp("127.0.0.1", tcp.port));
    listener = Descriptor(context ? modbus_tcp_listen(context.get(), SOMAXCONN) : -1);
    if (listener.get() < 0) fail(fmt::format("cannot listen on port {}", tcp.port));
    sockaddr_in address{};
    socklen_t size = sizeof address;
    if (::getsockname(listener.get(), reinterpret_cast<sockaddr*>(&address), &size) != 0) fail("cannot tell its port");
    tcp.port = ntohs(address.sin_port);
}

void VirtualModbus::Line::open_terminal(const VirtualModbusSerial& serial) {
    const std::string& device = terminal.emplace(serial.link).client_path();
    client_end = Descriptor(::open(device.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
    if (client_end.get() < 0) fail(fmt::format("cannot open {}", device));
    // The context wants a name to open, but is given the terminal's descriptor instead of opening it.
    context.reset(modbus_new_rtu(device.c_str(), 19200, 'N', 8, 1));
}

std::unique_ptr<VirtualModbus::Line> VirtualModbus::Line::open(std::variant<VirtualModbusTcp, VirtualModbusSerial>& where, int unit) {
    auto line = std::make_unique<Line>();
    if (auto* tcp = std::get_if<VirtualModbusTcp>(&where)) {
        line->listen(*tcp);
    } else {
        line->open_terminal(std::get<VirtualModbusSerial>(where));
    }
    modbus_set_slave(line->context.get(), unit);
    std::array<int, 2> sink{};
    if (::socketpair(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, sink.data()) != 0) fail("cannot have a socket");
    line->sink = Descriptor(sink[0]);
    line->sink_end = Descriptor(sink[1]);
    return line;
}

VirtualModbus::VirtualModbus(const Obstacle& obstacle, const VirtualModbusOptions& options,
                             std::variant<VirtualModbusTcp, VirtualModbusSerial> where, int unit)
    : where_(std::move(where)),
      unit_(unit),
      line_(Line::open(where_, unit)),
      device_(line_->device()),
      controller_(obstacle, options),
      advanced_to_(clock_.now()),
      thread_([this](const std::stop_token& stop) { serve(stop); }) {}

VirtualModbus::~VirtualModbus() = default;

ModbusLinkOptions VirtualModbus::link() const {
    const std::scoped_lock lock(mutex_);
    ModbusLinkOptions link;
    link.unit = unit_;
    if (const auto* tcp = std::get_if<VirtualModbusTcp>(&where_)) {
        link.where = ModbusTcp{"127.0.0.1", tcp->port};
    } else {
        const std::filesystem::path& name = std::get<VirtualModbusSerial>(where_).link;
        link.where = ModbusRtu{name.empty() ? device_ : name.string(), 19200, 'N', 1};
    }
    return link;
}

void VirtualModbus::inject(const AnswerFault& fault) {
    const std::scoped_lock lock(mutex_);
    faults_.push_back({fault});
}

void VirtualModbus::plug(bool plugged) {
    std::unique_lock lock(mutex_);
    wants_plug_ = plugged;
    plug_moved_.wait(lock, [&] { return is_plugged_ == plugged; });
}

void VirtualModbus::unplug() { plug(false); }
void VirtualModbus::replug() { plug(true); }

void VirtualModbus::send_stale(std::span<const std::uint8_t> bytes) {
    const std::scoped_lock lock(mutex_);
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (line_->terminal->write(text) != bytes.size()) fail(fmt::format("cannot write to {}", device_));
}

void VirtualModbus::advance() {
    const std::scoped_lock lock(mutex_);
    const auto now = clock_.now();
    controller_.advance(now - advanced_to_);
    advanced_to_ = now;
}

// The axes go on while an answer waits.
void VirtualModbus::wait(Seconds time, const std::stop_token& stop) {
    const auto until = clock_.now() + std::chrono::duration_cast<std::chrono::nanoseconds>(time);
    while (clock_.now() < until && !stop.stop_requested()) {
        clock_.sleep(
            std::min<std::chrono::nanoseconds>(std::chrono::duration_cast<std::chrono::nanoseconds>(kMovingTick), until - clock_.now()));
        advance();
    }
}

// Is the cable in?
bool VirtualModbus::follow_the_plug() {
    const std::scoped_lock lock(mutex_);
    if (is_plugged_ != wants_plug_) {
        line_.reset();
        is_plugged_ = false;
        if (wants_plug_) {
            try {
                line_ = Line::open(where_, unit_);
            } catch (const std::exception&) {
                return false;  // the port is not free yet: the next look tries again
            }
            device_ = line_->device();
            is_plugged_ = true;
        }
        plug_moved_.notify_all();
    }
    return is_plugged_;
}

void VirtualModbus::serve(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
        advance();
        std::vector<pollfd> watched;
        if (follow_the_plug()) {
            for (const Descriptor& peer : line_->peers) watched.push_back({peer.get(), POLLIN, 0});
            if (line_->terminal) watched.push_back({line_->terminal->descriptor(), POLLIN, 0});
            if (line_->listener.get() >= 0) watched.push_back({line_->listener.get(), POLLIN, 0});
        }
        const bool is_moving = with_controller([](const VirtualModbusController& c) { return c.tool().is_moving(); });
        const int patience = static_cast<int>((is_moving ? kMovingTick : kIdleTick) / Seconds(0.001));
        if (::poll(watched.data(), watched.size(), patience) <= 0) continue;
        for (const pollfd& one : watched) {
            if (one.revents == 0 || !line_) continue;
            if (one.fd != line_->listener.get()) {
                answer(one.fd, stop);
            } else if (const int peer = ::accept4(one.fd, nullptr, nullptr, SOCK_CLOEXEC); peer >= 0) {
                line_->peers.emplace_back(peer);
            }
        }
    }
}

void VirtualModbus::answer(int peer, const std::stop_token& stop) {
    std::array<std::uint8_t, MODBUS_TCP_MAX_ADU_LENGTH> request{};
    modbus_set_socket(line_->context.get(), peer);
    const int length = modbus_receive(line_->context.get(), request.data());
    if (length > 0) {
        advance();
        ++requests_;
        reply(peer, std::span(request).first(static_cast<std::size_t>(length)), stop);
    } else if (length < 0 && line_->listener.get() >= 0) {
        std::erase_if(line_->peers, [&](const Descriptor& one) { return one.get() == peer; });
    } else if (length < 0) {
        modbus_flush(line_->context.get());  // half a frame
    }
}

void VirtualModbus::hang_up(int peer, bool unplug) {
    if (!unplug && line_->listener.get() >= 0) {
        std::erase_if(line_->peers, [&](const Descriptor& one) { return one.get() == peer; });
        return;
    }
    const std::scoped_lock lock(mutex_);
    line_.reset();
    is_plugged_ = false;
    wants_plug_ = !unplug;
    plug_moved_.notify_all();
}

// The fault of this request, if one is due.
std::optional<AnswerFault> VirtualModbus::next_fault() {
    const auto now = clock_.now();
    for (DueFault& due : faults_) --due.fault.nth;
    std::erase_if(faults_, [now](const DueFault& due) { return due.until && now >= *due.until; });
    const auto found = std::ranges::find_if(faults_, [](const DueFault& due) { return due.fault.nth <= 0; });
    if (found == faults_.end()) return std::nullopt;
    const AnswerFault fault = found->fault;
    if (fault.lasting.count() <= 0.0) {
        faults_.erase(found);
    } else if (!found->until) {
        found->until = now + std::chrono::duration_cast<std::chrono::nanoseconds>(fault.lasting);
    }
    return fault;
}

// Of a request whose function begins at `header`. The number of an exception if it is refused.
std::optional<int> VirtualModbus::carry_out(std::span<const std::uint8_t> request, int header) {
    const auto body = request.subspan(static_cast<std::size_t>(header));
    const auto word = [&](std::size_t at) { return static_cast<std::uint16_t>((body[at] << 8U) | body[at + 1]); };
    const int function = body[0];
    const bool reads = function == kReadRegisters || function == kWriteAndReadRegisters;
    const bool writes_many = function == kWriteRegisters || function == kWriteAndReadRegisters;
    if (!reads && !writes_many && function != kWriteRegister) return kIllegalFunction;
    if (function == kWriteAndReadRegisters && !controller_.profile().read_write) return kIllegalFunction;
    // libmodbus has received all that the function needs: an address and a word; what FC16 and FC23 announce as their bytes, too.
    if (reads) {
        const std::size_t count = word(3);
        if (count == 0 || count > MODBUS_MAX_READ_REGISTERS) return kIllegalValue;
        if (const auto refusal = controller_.refuses_to_read(word(1), static_cast<int>(count))) return refusal;
        if (function == kReadRegisters) return std::nullopt;
    }
    const std::size_t begin = reads ? 5 : 1;  // of what is written
    const int address = word(begin);
    const std::size_t count = writes_many ? word(begin + 2) : 1;
    if (count == 0 || (writes_many && body[begin + 4] != 2 * count)) return kIllegalValue;
    const std::size_t first = begin + (writes_many ? 5 : 2);
    std::vector<std::uint16_t> words;
    for (std::size_t i = 0; i < count; ++i) words.push_back(word(first + 2 * i));
    if (const auto refusal = controller_.refuses_to_write(address, static_cast<int>(words.size()))) return refusal;
    controller_.write(address, words);
    return std::nullopt;
}

void VirtualModbus::reply(int peer, std::span<std::uint8_t> request, const std::stop_token& stop) {
    modbus_t* context = line_->context.get();
    const int header = modbus_get_header_length(context);
    std::uint8_t& unit = request[static_cast<std::size_t>(header) - 1];
    if (unit != unit_) return;  // another's
    std::optional<AnswerFault> fault;
    std::optional<int> refusal;
    std::unique_ptr<modbus_mapping_t, FreeMapping> mapping;
    {
        const std::scoped_lock lock(mutex_);
        using Kind = AnswerFault::Kind;
        fault = next_fault();
        if (fault && fault->kind == Kind::exception) {
            refusal = fault->code;
        } else {
            refusal = carry_out(request, header);
        }
        // As they are now, however late the answer.
        const std::span<const std::uint16_t> registers = controller_.registers();
        mapping.reset(modbus_mapping_new_start_address(0, 0, 0, 0, static_cast<unsigned>(controller_.first_address()),
                                                       static_cast<unsigned>(registers.size()), 0, 0));
        std::ranges::copy(registers, mapping->tab_registers);
    }
    if (fault && fault->kind >= AnswerFault::Kind::hang_up) return hang_up(peer, fault->kind == AnswerFault::Kind::unplug);
    if (fault && fault->kind == AnswerFault::Kind::late) wait(fault->delay, stop);
    if (fault && fault->kind == AnswerFault::Kind::other_unit) ++unit;
    modbus_set_socket(context, fault && fault->kind == AnswerFault::Kind::lost ? line_->sink.get() : peer);
    if (refusal) {
        modbus_reply_exception(context, request.data(), static_cast<unsigned>(*refusal));
    } else {
        modbus_reply(context, request.data(), static_cast<int>(request.size()), mapping.get());
    }
}

}  // namespace palpate
