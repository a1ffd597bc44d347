#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "config/config_error.h"
#include "devices/calibration/probe_calibration.h"
#include "devices/errors.h"
#include "devices/session/journaling_device.h"
#include "planner/errors.h"
#include "planner/probe_surface.h"
#include "sim/objects/errors.h"
#include "tools/commands/commands.h"
#include "tools/session_files.h"

namespace palpate {

namespace {

void tell(Output& output, const std::string& what, ExitCode code) {
    output.console.write(fmt::format("palpate: {}\n", what));
    if (output.events == nullptr) return;
    using Json = nlohmann::ordered_json;
    const Json event = {{"event", "error"}, {"exit_code", static_cast<int>(code)}, {"text", what}};
    output.events->write(event_line(event));
}

}  // namespace

ExitCode exit_code_of(const Result& result) {
    switch (result.certificate.status) {
        case Certificate::Status::incomplete:
            return ExitCode::incomplete;  // whatever else is refuted
        case Certificate::Status::refuted:
            return ExitCode::refuted;
        case Certificate::Status::certified:
        case Certificate::Status::conditional:
            break;
    }
    return ExitCode::done;
}

ExitCode explain_current_exception(Output& output) {
    const auto say = [&](const std::exception& error, ExitCode code) {
        tell(output, error.what(), code);
        return code;
    };
    try {
        throw;
    } catch (const ConfigError& error) {
        return say(error, ExitCode::usage);
    } catch (const ObjectError& error) {
        return say(error, ExitCode::usage);
    } catch (const SetupError& error) {
        return say(error, ExitCode::usage);
    } catch (const CalibrationError& error) {
        return say(error, ExitCode::usage);
    } catch (const OutputError& error) {
        return say(error, ExitCode::usage);
    } catch (const SeedError& error) {
        return say(error, ExitCode::usage);
    } catch (const std::invalid_argument& error) {
        return say(error, ExitCode::usage);
    } catch (const DeviceError& error) {
        return say(error, ExitCode::device);
    } catch (const ContradictionError& error) {
        return say(error, ExitCode::device);
    } catch (const JournalDamaged& error) {
        return say(error, ExitCode::usage);
    } catch (const ReplayMismatch& error) {
        return say(error, ExitCode::usage);
    } catch (const std::exception& error) {
        tell(output, fmt::format("internal error: {}\nThis is a bug; please report it with the configuration that shows it.", error.what()),
             ExitCode::internal);
        return ExitCode::internal;
    }
}

}  // namespace palpate
