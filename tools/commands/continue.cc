// palpate continue: a session goes on from another's touches, finer or with a tolerance.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "config/reader.h"
#include "tools/commands/new_session.h"
#include "tools/earlier_session.h"
#include "tools/session_files.h"
#include "tools/session_folder.h"
#include "tools/session_plan.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

// What is asked for from now on; within the box alone, if there is one.
void refine(Options& options, const ContinueCommand& command) {
    constexpr double kMost_mm = 1e6;  // as config/README.md has it
    const auto is_long = [](double x) { return std::abs(x) > kMost_mm; };
    if (std::ranges::any_of(command.box, is_long) || is_long(command.epsilon.value_or(0)) || is_long(command.tolerance.value_or(0)))
        throw SetupError("--box, --epsilon, --tolerance: a length is out of range; allowed: from -1000000 to 1000000 mm");
    if (command.tolerance) options.tolerance_box.reset();
    // A proof needs no tolerance, and the configuration may give a bound that it rests on.
    if (command.tolerance && options.strategy.infer == Strategy::Infer::automatic) options.strategy.infer = Strategy::Infer::adaptive;
    if (command.box.empty()) {
        if (command.epsilon) options.epsilon = *command.epsilon;
        if (command.tolerance) options.tolerance = command.tolerance;
        return;
    }
    const auto& b = command.box;
    const Box box{{b[0], b[1], b[2]}, {b[3], b[4], b[5]}};
    if (!box.is_valid())
        throw SetupError(
            "--box: the second corner is not above the first in x, y and z; allowed: X,Y,Z of the lowest and of the highest corner (mm)");
    if (!command.epsilon && !command.tolerance) throw SetupError("--box: says where, but not what: give --epsilon or --tolerance as well");
    if (command.epsilon) options.sizing.regions.push_back({box, *command.epsilon});
    if (!command.tolerance) return;
    options.tolerance = command.tolerance;
    options.tolerance_box = box;
}

}  // namespace

ExitCode run(const ContinueCommand& command, Output& output) {
    const fs::path earlier = folder_of(command.earlier);
    const fs::path file = earlier / kConfigFile;
    std::error_code error;
    if (!fs::is_regular_file(file, error)) {
        throw SetupError(
            fmt::format("{}: holds no {}; give the folder of a session. From a touches.csv alone a configuration goes on that names it: "
                        "probing.earlier",
                        earlier.string(), kConfigFile));
    }
    SessionConfig config = read_config(file, command.overrides);
    refine(config.probing, command);
    config.earlier.file.clear();  // those are among what was touched
    config = with_its_files(std::move(config));
    std::vector<fs::path> inputs = inputs_of(config, file);
    for (const char* name : kSessionFiles) inputs.push_back(earlier / name);
    NewSession session{std::move(config), std::move(inputs), command.folder, command.picture};
    keep_earlier(session, earlier_touches_in(earlier));
    session.config.probing.earlier = parse_touches(session.earlier, session.config.earlier.file.string());
    const bool was_on_machine = fs::exists(earlier / kJournalFile, error);
    return was_on_machine ? begin_on_machine(session, command.yes, output) : begin_simulation(session, command.force, output);
}

}  // namespace palpate
