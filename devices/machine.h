// The seam between a session and a machine: a driver that is connected, and what a session asks of it besides guarded moves.
#pragma once

#include "devices/machine_report.h"
#include "devices/probe_device.h"

namespace palpate {

// Constructing one connects and moves nothing; a move under way that has to end is ended by the stop token that it is constructed with.
// Every call throws a DeviceError (devices/errors.h) on a fault.
class Machine {
public:
    virtual ~Machine() = default;

    // Positions are the session's: the machine's less the origin. Lives as long as the machine.
    [[nodiscard]] virtual ProbeDevice& device() = 0;
    // As it is now. Moves nothing.
    [[nodiscard]] virtual MachineReport report() = 0;
    // Makes it fit to move: homes, unlocks or refuses, as its settings say. To be called before the first move. Throws ProbeClosed if
    // the probe is closed.
    virtual void make_ready() = 0;
    // Off a surface that an earlier session left the probe on, straight towards `target`, which it came from. make_ready() follows.
    virtual void retreat(const Point& target) = 0;
    [[nodiscard]] virtual bool is_probe_closed() = 0;
    // Whether the machine says that it knows where it is.
    [[nodiscard]] virtual bool is_position_trusted() = 0;
};

}  // namespace palpate
