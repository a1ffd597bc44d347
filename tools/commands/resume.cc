// palpate resume: a session goes on, or is replayed.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "config/reader.h"
#include "config/writer.h"
#include "tools/commands/commands.h"
#include "tools/operated_session.h"
#include "tools/session_files.h"
#include "tools/session_folder.h"
#include "tools/session_plan.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

bool is_budget(std::string_view word) { return word.starts_with("probing.budget"); }

// What the planner asks must not change; where the port is today may, and how much the run may use up.
void check_overrides(const ResumeCommand& command) {
    constexpr std::array<std::string_view, 2> kAllowed = {"machine.homing=", "machine.probe_proof="};
    if (command.replay && !command.overrides.empty()) throw SetupError("--set: a replay has no machine that it could be for");
    for (const std::string& word : command.overrides) {
        if (is_connection_key(word) || is_budget(word) ||
            std::ranges::any_of(kAllowed, [&](std::string_view allowed) { return word.starts_with(allowed); }))
            continue;
        throw SetupError(fmt::format(
            "--set {}: a session goes on as it began; allowed: machine.homing, machine.probe_proof, a larger probing.budget, and what is "
            "below {}",
            word, connection_keys()));
    }
}

template <typename Number>
bool is_smaller(const std::optional<Number>& a, const std::optional<Number>& b) {
    return a && (!b || *a < *b);
}

// A session that goes on with a larger budget: the plan with it, for a journal that goes by `before`. Throws SetupError if that adds
// nothing.
SessionPlan raise_budget(const SessionPlan& before, const SessionConfig& after, const std::string& text, StopSignals& signals) {
    const Budget& was = before.probing.budget;
    const Budget& is = after.probing.budget;
    if (is_smaller(is.probes, was.probes) || is_smaller(is.displacement, was.displacement) ||
        is_smaller(is.machine_time, was.machine_time)) {
        throw SetupError("--set: a budget can be raised only: what was used up stays used up");
    }
    const fs::path folder = before.journal.parent_path();
    SessionPlan plan = plan_session(after, folder, text);
    if (plan.config_digest == before.config_digest) throw SetupError("--set: that is the session's budget already");
    const Journal journal = read_journal(before.journal);
    check_plan(journal, before);
    if (journal.end) {
        SessionHost host;
        host.stop = signals.token();
        host.pause = [&signals] { signals.pause(); };
        if (!is_stopped_by_budget(replay_session(before, host).result.certificate)) {
            throw SetupError(fmt::format("{}: this session has come to its own end; a larger budget adds nothing to it", folder.string()));
        }
    }
    plan.raised_from = before.config_digest;
    return plan;
}

void salvage(const fs::path& journal) {
    const std::optional<JournalCut> cut = salvage_journal(journal);
    if (cut && !cut->raised.empty()) {
        // The configuration may be the one of a larger budget, of which nothing that is left tells.
        JournalWriter writer(journal);
        (void)writer.read();
        for (const std::string& digest : cut->raised) writer.append_raised(digest);
    }
    if (!cut) return spdlog::info("{}: is whole; nothing was cut off", journal.string());
    spdlog::warn("{}; cut off there: {} line(s) are left, {} are not; the damaged journal is kept as {}", cut->damage, cut->lines,
                 cut->lost, cut->kept.string());
}

}  // namespace

ExitCode run(const ResumeCommand& command, Output& output) {
    StopSignals signals;
    const SessionFolder opened = SessionFolder::open(command.folder);
    const fs::path& folder = opened.path();
    check_overrides(command);
    if (command.salvage) salvage(folder / kJournalFile);
    std::vector<std::string> budget = command.overrides;
    std::vector<std::string> reach = command.overrides;
    std::erase_if(budget, [](const std::string& word) { return !is_budget(word); });
    std::erase_if(reach, [](const std::string& word) { return is_budget(word); });
    const fs::path file = folder / kConfigFile;
    const SessionConfig config = with_its_files(read_config(file, command.overrides));
    (void)machine_workspace(config);
    SessionPlan plan = plan_session(config, folder, read_file(file));
    SessionHost host = host_for(config, command.yes, output, signals);
    if (!budget.empty()) {
        // As it is to be kept: how the machine is reached today is not.
        const std::string text = write_config(read_config(file, budget), folder);
        const SessionConfig before = with_its_files(read_config(file, reach));
        plan = raise_budget(plan_session(before, folder, read_file(file)), config, text, signals);
        host.on_raised = [file, text] { write_file(file, text); };
    }
    return run_session(plan, config, folder, command.picture, std::move(host), output, signals,
                       command.replay ? replay_session : resume_session);
}

}  // namespace palpate
