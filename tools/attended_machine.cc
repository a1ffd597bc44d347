#include "tools/attended_machine.h"

#include <fmt/format.h>

#include "devices/errors.h"
#include "planner/number_text.h"
#include "tools/machine.h"
#include "tools/terminal/consent.h"
#include "tools/terminal/probe_proof.h"

namespace palpate {
namespace {

void require_inside(const MachineConfig& config, const Point& position) {
    const Box& limits = config.limits;
    if (limits.contains(position, config.motion.resolution_mm)) return;
    throw SetupError(fmt::format("the tool is at {}, outside machine.limits, {} to {}: move it inside them by hand, then start again",
                                 point_text(position), point_text(limits.min), point_text(limits.max)));
}

}  // namespace

void let_move(Machine& machine, const MachineReport& report, const MachineConfig& config, const std::string& what, bool yes,
              Console& console, StopSignals& signals) {
    const bool is_placed = machine.is_position_trusted() && !config.homes_first(report);
    if (is_placed) require_inside(config, report.position);
    ask_consent(describe_plan(report, config, what), yes, console, signals);
    if (is_proven_by_hand(config.probe_proof, !yes) && !see_probe_pressed(machine, "stop", console, signals)) {
        throw DeviceError("the probe was not seen to close and to open; nothing has moved. Look at its lead, plug and battery");
    }
    machine.make_ready();
    require_inside(config, machine.device().position());
}

}  // namespace palpate
