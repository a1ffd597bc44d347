// What a virtual machine sees of the line that its clients come by. Nothing here waits.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace palpate {

class ClientEnd {
public:
    virtual ~ClientEnd() = default;

    // What a client opens.
    [[nodiscard]] virtual std::string client_path() const = 0;
    // For poll, -1 for none: bytes may have come, or the client has gone; somebody comes.
    [[nodiscard]] virtual int descriptor() const = 0;
    [[nodiscard]] virtual int openings_descriptor() const = 0;

    // False until a client comes, and after the last one has gone.
    [[nodiscard]] virtual bool has_client() const = 0;
    // Has somebody come since this was asked last? What a client writes is never read before its coming can be seen here.
    [[nodiscard]] virtual bool take_openings() = 0;
    // What has come. Empty if that is nothing, or nobody is there.
    [[nodiscard]] virtual std::string read() = 0;
    // How many of the bytes were taken: fewer if the client does not read, none if nobody is there.
    [[nodiscard]] virtual std::size_t write(std::string_view bytes) = 0;
};

}  // namespace palpate
