// A port of this computer's own network, which one client at a time may come to.
#pragma once

#include <string>

#include "sim/machines/client_end.h"

namespace palpate {

// While somebody is there, further ones are refused, as by a controller with one place. Closing it ends the connection.
class TcpClientEnd final : public ClientEnd {
public:
    // Of 127.0.0.1. `port` 0: any that is free. Throws ConnectionLost (devices/errors.h) if it cannot be listened at.
    explicit TcpClientEnd(int port);
    ~TcpClientEnd() override;
    TcpClientEnd(const TcpClientEnd&) = delete;
    TcpClientEnd& operator=(const TcpClientEnd&) = delete;
    TcpClientEnd(TcpClientEnd&&) = delete;
    TcpClientEnd& operator=(TcpClientEnd&&) = delete;

    [[nodiscard]] std::string client_path() const override;
    [[nodiscard]] int port() const { return port_; }
    [[nodiscard]] int descriptor() const override { return client_; }
    [[nodiscard]] int openings_descriptor() const override { return listener_; }
    [[nodiscard]] bool has_client() const override { return client_ >= 0; }
    [[nodiscard]] bool take_openings() override;
    [[nodiscard]] std::string read() override;
    [[nodiscard]] std::size_t write(std::string_view bytes) override;
    // Ends the connection of whoever is there.
    void hang_up() {
        if (client_ >= 0) drop_client();
    }

private:
    void listen();
    void drop_client();

    int port_;
    int listener_ = -1;  // while nobody is there
    int client_ = -1;
    bool opened_ = false;
};

}  // namespace palpate
