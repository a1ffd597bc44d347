// A wire to a virtual GRBL controller in the same process, and its clock: virtual time, no threads, the same every time.
#pragma once

#include "devices/byte_stream.h"
#include "devices/clock.h"
#include "sim/machines/grbl/virtual_grbl.h"

namespace palpate {

// Time passes in read() while it waits, in sleep(), for every byte that is written, and a little in every call, so that no loop around
// it stands still.
class LoopbackStream final : public ByteStream, public Clock {
public:
    // `grbl` must outlive the stream.
    explicit LoopbackStream(VirtualGrbl& grbl) : grbl_(grbl) {}

    [[nodiscard]] std::string read(std::chrono::milliseconds timeout) override;
    void write(std::string_view bytes) override;
    [[nodiscard]] std::string name() const override { return "virtual GRBL"; }

    // Time of the machine.
    [[nodiscard]] std::chrono::nanoseconds now() const override;
    void sleep(std::chrono::nanoseconds duration) override { grbl_.advance(duration); }

    // Of one byte at 115200 baud, ten bits each.
    static constexpr Seconds kByteTime{10.0 / 115200.0};
    // Of a call to the operating system and back.
    static constexpr Seconds kCallTime{0.0001};

private:
    void check_link() const;

    VirtualGrbl& grbl_;
};

}  // namespace palpate
