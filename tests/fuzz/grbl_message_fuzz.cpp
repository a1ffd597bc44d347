// Bytes from a serial line, as lines and as messages.
#include <string>

#include "devices/grbl/grbl_message.h"
#include "tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace palpate;
    using namespace palpate::grbl;
    LineBuffer buffer;
    std::size_t seen = 0;
    // In two pieces, as a port may hand it over.
    const std::string bytes(reinterpret_cast<const char*>(data), size);
    buffer.append(bytes.substr(0, size / 2));
    buffer.append(bytes.substr(size / 2));
    while (const auto line = buffer.next()) {
        require(!line->empty(), "a line is not empty");
        seen += line->size();
        const Message message = parse(*line);
        if (const auto* report = std::get_if<ProbeReport>(&message)) require(report->position.allFinite(), "coordinates are finite");
        if (const auto* status = std::get_if<Status>(&message)) {
            require(status->machine || status->work, "a status says where the machine is");
            require(!status->machine || status->machine->allFinite(), "coordinates are finite");
        }
    }
    require(seen <= size, "no byte comes twice");
    return 0;
}
