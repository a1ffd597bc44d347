// palpate conformance: whether a machine does what a session relies on.
#include "devices/conformance.h"

#include <fmt/format.h>

#include <ostream>

#include "config/reader.h"
#include "devices/clock.h"
#include "devices/errors.h"
#include "planner/number_text.h"
#include "tools/commands/commands.h"
#include "tools/machine.h"
#include "tools/session_plan.h"
#include "tools/terminal/consent.h"
#include "tools/terminal/stop_signals.h"

namespace palpate {
namespace {

const char* to_word(Conformance::Verdict verdict) {
    switch (verdict) {
        case Conformance::Verdict::good:
            return "good";
        case Conformance::Verdict::bad:
            return "BAD";
        case Conformance::Verdict::skipped:
            return "not tried";
    }
    return "";
}

const char* to_request(ConformanceAudience::Hand hand) {
    switch (hand) {
        case ConformanceAudience::Hand::hold:
            return "\n>>> Press the probe now, and HOLD it.\n\n";
        case ConformanceAudience::Hand::let_go:
            return "\n>>> LET GO of the probe now.\n\n";
        case ConformanceAudience::Hand::tap:
            return "\n>>> It moves now: TAP the probe once, shortly.\n\n";
    }
    return "";
}

}  // namespace

ExitCode run(const ConformanceCommand& command, Output& output) {
    StopSignals signals;
    const SessionConfig config = read_config(command.config, command.overrides);
    if (!config.machine) throw SetupError(fmt::format("machine: missing; there is nothing to try without {}", connection_keys()));
    const MachineConfig& machine_config = *config.machine;
    if (!(command.reach > 0)) throw SetupError("--reach: allowed: greater than 0 (mm)");
    {
        const std::unique_ptr<Machine> machine = connect(machine_config, signals.token());
        ask_consent(
            describe_plan(
                machine->report(), machine_config,
                fmt::format("It will move, guarded, to and fro within {} of where it stands, inside machine.limits, for a minute or "
                            "two, and be stopped in mid-move: that space has to be free.{}",
                            number_text(command.reach, " mm"),
                            machine_config.homing == Homing::run
                                ? " Once the probe was held closed it may be locked, and is homed again, unguarded."
                                : "")),
            command.yes, output.console, signals);
    }
    SteadyClock clock;
    ConformanceOptions options{machine_config.motion, machine_config.limits, command.reach};
    ConformanceAudience audience;
    audience.tell = [&](const Conformance& found) {
        output.results << fmt::format("{:<10} {}{}{}\n", to_word(found.verdict), found.what, found.why.empty() ? "" : ": ", found.why)
                       << std::flush;
    };
    if (command.hand) {
        audience.ask_hand = [&](ConformanceAudience::Hand hand) { output.results << to_request(hand) << std::flush; };
    }
    const bool is_good =
        try_conformance([&](const StopToken& stop) { return connect(machine_config, stop); }, clock, options, audience, signals.token());
    signals.release();
    return is_good ? ExitCode::done : ExitCode::device;
}

}  // namespace palpate
