// A virtual GRBL machine behind a serial port of this computer, or on its own network, for any program that talks to one.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "sim/machines/client_end.h"
#include "sim/machines/grbl/virtual_grbl.h"

namespace palpate {

struct GrblHostOptions {
    enum class Time {
        real,  // motion takes as long as on a machine
        fast,  // once all bytes are handled, time jumps to the next event
    };
    std::filesystem::path link{};  // to the client's end; none if empty
    Time time = Time::real;
    bool reset_on_open = false;     // as a USB port does that pulls DTR
    std::optional<int> tcp_port{};  // of 127.0.0.1, 0 for any, instead of a serial port
    bool greets_clients = false;    // with its banner, without a reset, as grblHAL does on a network
};

// Runs the machine in a thread of its own, from construction to destruction. Clients may come and go; what the machine says while none is
// there is lost. A fault of the script that cuts the link ends the connection.
class GrblHost {
public:
    // `grbl` must outlive the host; until then, reach it through with() only. Throws ConnectionLost if there is no pseudo-terminal, or
    // the port is taken.
    GrblHost(VirtualGrbl& grbl, GrblHostOptions options);
    ~GrblHost();
    GrblHost(const GrblHost&) = delete;
    GrblHost& operator=(const GrblHost&) = delete;

    // What a client opens; changes when it is plugged in again. Empty while unplugged.
    [[nodiscard]] std::string client_path() const;
    // The machine stands still meanwhile. The tool that it moves, and its account, may be read there too.
    void with(const std::function<void(VirtualGrbl&)>& use);
    // Both return when it is done. Throws as the constructor.
    void unplug();
    void plug_in();

private:
    class Wake;

    [[nodiscard]] std::shared_ptr<ClientEnd> open() const;
    void serve(const std::stop_token& stop);
    void let_time_pass(std::chrono::nanoseconds passed);
    [[nodiscard]] bool pass_bytes(ClientEnd& end);
    [[nodiscard]] bool jump_to_event();
    void greet_client();
    void sleep(const ClientEnd* end);

    VirtualGrbl& grbl_;
    GrblHostOptions options_;
    std::unique_ptr<Wake> wake_;
    mutable std::mutex mutex_;  // over grbl_ and end_
    std::condition_variable closed_;
    std::shared_ptr<ClientEnd> end_;
    std::string to_send_;  // of the thread alone
    std::jthread thread_;  // last: it uses all of the above
};

}  // namespace palpate
