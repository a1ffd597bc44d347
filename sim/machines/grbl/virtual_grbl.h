// A GRBL controller of a virtual machine, as a pure state machine: bytes in, bytes out, and time passes only when told.
// It does what devices/FACTS.md, "GRBL" says of Grbl 1.1h and grblHAL 1.1f, and "GRBL over TCP" of FluidNC.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/machines/virtual_tool.h"

namespace palpate {

class GrblMachine;

enum class GrblDialect { grbl, grblhal, fluidnc };

// Something that goes wrong, once, at a given moment.
struct VirtualFault {
    enum class Kind {
        stale_line,        // `text` comes out before the answer
        lose_output,       // the next `argument` bytes of output are lost
        late_answer,       // what comes out from now on is held back for `argument` seconds
        hang_up,           // the cable is pulled: the client sees the end of the file
        io_error,          // reads and writes fail with an input/output error
        press_reset,       // the reset button: the count of steps is lost too
        spurious_trigger,  // the probe closes; of a probe move, after the share `argument` (0 to 1) of its time
        bounce,            // the probe opens and closes `argument` times at the next touch and the next release
        missed_trigger,    // the next touch does not close the probe
        cut_probe,         // the lead of the probe is cut: it never closes again
        dead_probe,        // the probe dies and the firmware does not notice: it reads as one that is open
        mend_probe,        // ends dead_probe
        pendant_key,       // the real-time byte `argument` comes from a pendant: overrides, hold, coolant
        spindle,           // a pendant commands M`argument`: 3, 4 or 5
        // What reports say of the position from now on, whatever [PRB:…] says:
        position_zero,     // 0,0,0
        position_frozen,   // where it is now
        position_ahead,    // `argument` mm farther in the direction of the last probe move
        position_beside,   // told across the way
        position_swapped,  // x as y and y as x
        latch_late,        // a probe move latches where it is `argument` s later at its feed, or earlier, from now on
        alarm,             // ALARM:`argument`, instead of the line or the probe move
        silence,           // the controller dies: nothing moves or answers any more, until the reset button is pressed
    };
    enum class When {
        line,     // as the `at`-th line that is not empty is about to be executed; counts from 1
        probe,    // as the `at`-th G38 move begins; counts from 1
        contact,  // as the tool has come to rest after the `at`-th contact, before it is told; counts from 1
        time,     // `at` seconds after power-on
    };
    Kind kind = Kind::stale_line;
    When when = When::line;
    double at = 1.0;
    double argument = 0.0;
    std::string text{};  // without CR LF
};

struct VirtualGrblOptions {
    GrblDialect dialect = GrblDialect::grbl;
    bool locked = false;                   // starts in alarm, until $H or $X
    bool homing = true;                    // $22
    bool knows_position = true;            // at power-on; else it counts from zero wherever the tool is, until it is homed
    Point homed_position = Point::Zero();  // mm, machine coordinates, after $H
    bool soft_limits = false;              // $20, at the limits of the tool
    int status_mask = 1;                   // $10: bit 0 is MPos instead of WPos
    bool report_inches = false;            // $13
    bool reports_overrides = true;         // Ov and A; a build option, on grblHAL a bit of $10
    bool reports_offset = true;            // WCO; likewise
    bool reports_pins = true;              // Pn; likewise
    bool reports_probes = true;            // [PRB] after a probing move; on grblHAL a bit of $10
    Point work_offset = Point::Zero();     // mm, G54
    bool fresh_eeprom = false;             // error:7 and all settings come before the first banner
    double max_feed_mm_per_s = 100.0;      // $110 to $112
    Seconds parse_time{0};                 // of a probing line, in which the machine says that it is idle
    // Chances that a G38 move triggers somewhere on its way though it touches nothing, or bounces where it touches.
    double spurious_rate = 0.0;
    double bounce_rate = 0.0;
    double miss_rate = 0.0;  // that a touch does not close the probe
    std::uint64_t seed = 1;  // of the three
    std::vector<VirtualFault> faults{};
};

class VirtualGrbl {
public:
    // `tool` must outlive this; nobody else may move it. It is powered on: its banner can be taken.
    VirtualGrbl(VirtualTool& tool, const VirtualGrblOptions& options);
    ~VirtualGrbl();
    VirtualGrbl(VirtualGrbl&&) noexcept;

    // Real-time bytes (? ! ~ 0x18 0x85, overrides 0x90 to 0xA1) act at once; the rest goes into the receive buffer, and what finds it full
    // is lost.
    void receive(std::string_view bytes);
    void advance(Seconds time);
    [[nodiscard]] std::string take_output();
    // What it says when it starts, with the end of the line.
    [[nodiscard]] std::string banner() const;
    // Until something happens by itself. Nothing if only bytes will make it do anything.
    [[nodiscard]] std::optional<Seconds> time_to_event() const;
    [[nodiscard]] bool is_busy() const { return time_to_event().has_value(); }

    // As the button, or DTR of a USB port that is opened.
    void press_reset();

    // The cable. The machine does not notice when it is pulled, and what it says meanwhile is lost.
    enum class Link { up, hung_up, io_error };
    [[nodiscard]] Link link() const;
    void unplug();
    void plug_in();

    struct Counts {
        std::uint64_t lines = 0;     // not empty
        std::uint64_t probes = 0;    // G38 moves that began
        std::uint64_t spurious = 0;  // triggers without a touch, by faults and by spurious_rate
        std::uint64_t resets = 0;    // banners after the first
    };
    [[nodiscard]] const Counts& counts() const;
    [[nodiscard]] const VirtualTool& tool() const;
    [[nodiscard]] Seconds now() const;  // since power-on

private:
    std::unique_ptr<GrblMachine> machine_;
};

}  // namespace palpate
