#include <iostream>

#include "config/config_error.h"
#include "devices/errors.h"
#include "devices/session/journaling_device.h"
#include "planner/errors.h"
#include "planner/probe_surface.h"
#include "sim/objects/errors.h"
#include "tools/commands/commands.h"
#include "tools/session_files.h"

namespace palpate {

ExitCode exit_code_of(const Result& result) {
    return result.certificate.status == Certificate::Status::incomplete ? ExitCode::incomplete : ExitCode::done;
}

ExitCode explain_current_exception() {
    const auto say = [](const std::exception& error, ExitCode code) {
        std::cerr << "palpate: " << error.what() << '\n';
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
        std::cerr << "palpate: internal error: " << error.what()
                  << "\nThis is a bug; please report it with the configuration that shows it.\n";
        return ExitCode::internal;
    }
}

}  // namespace palpate
