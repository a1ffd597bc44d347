// palpate bench: strategies beside each other.
#include "tools/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <ostream>

#include "config/reader.h"
#include "config/strategy_names.h"
#include "devices/errors.h"
#include "tools/anytime.h"
#include "tools/commands/commands.h"
#include "tools/hindsight.h"
#include "tools/reliability.h"
#include "tools/session_files.h"
#include "tools/session_plan.h"

namespace palpate {

ExitCode run(const BenchCommand& command, Output& output) {
    StopSignals signals;
    std::ostream& out = output.results;
    std::vector<Strategy> strategies;
    for (const std::string& name : command.strategies) strategies.push_back(parse_strategy(name));
    // All that can fail without a run fails before the first.
    const std::filesystem::path csv = command.output.string() + ".csv";
    const std::filesystem::path other = command.output.string() + (command.anytime || command.reliability ? ".svg" : ".json");
    if (command.anytime && command.reliability) throw SetupError("bench: give --anytime or --reliability, not both");
    if (command.anytime && command.configs.size() != 1) throw SetupError("bench --anytime draws one plot: give one configuration");
    for (const auto& file : {csv, other}) refuse_to_replace(file, command.force);
    if (!std::filesystem::exists(csv)) {
        write_file(csv, "");
        std::filesystem::remove(csv);
    }
    std::vector<std::pair<SessionConfig, Scene>> scenes;
    for (const auto& file : command.configs) {
        SessionConfig config = with_its_files(read_config(file, command.overrides));
        if (config.tool || !config.fixtures.solids.empty() || config.area) {
            throw SetupError(
                fmt::format("{}: tool, workspace.fixtures, probing.area: results are compared with the object, of which a tool touches "
                            "something else; leave them out",
                            file.string()));
        }
        Scene scene = build_scene(config);
        print_warnings(scene.object);
        warn_of_false_reach(config, scene.object);
        scenes.emplace_back(std::move(config), std::move(scene));
    }

    if (command.anytime) {
        out << "method, probes, displacement (mm), Hausdorff distance (mm)\n";
        const auto points =
            measure_anytime(command.configs[0].stem().string(), scenes[0].first, scenes[0].second, strategies, [&](const AnytimePoint& p) {
                out << p.method << ", " << p.probes << ", " << p.displacement << ", " << p.hausdorff << std::endl;
            });
        write_file(csv, anytime_csv(points));
        write_file(other, anytime_svg(points));
        return ExitCode::done;
    }

    std::vector<BenchRow> rows;
    std::vector<ExitCode> codes;
    for (std::size_t k = 0; k < scenes.size(); ++k) {
        auto& [config, scene] = scenes[k];
        for (const Strategy& strategy : strategies) {
            config.probing.strategy = strategy;
            rows.push_back({command.configs[k].stem().string(), strategy, config.probing.epsilon,
                            simulate_with_progress(config, scene, output, signals)});
            if (signals.token().stop_requested()) throw Stopped("stopped; nothing was written");
            warn_of_other_truth(rows.back().run);
            codes.push_back(exit_code_of(rows.back().run.result));
        }
    }
    if (command.reliability) {
        const std::vector<ReliabilityBin> bins = measure_reliability(rows);
        if (bins.empty()) throw SetupError("bench --reliability: no strategy left facets that are plausible only: name adaptive");
        out << reliability_table(bins);
        write_file(csv, reliability_csv(bins));
        write_file(other, reliability_svg(bins));
    } else {
        out << bench_table(rows, output.columns);
        write_file(csv, bench_csv(rows));
        write_file(other, bench_json(rows));
    }
    for (const ExitCode worst : {ExitCode::incomplete, ExitCode::refuted}) {
        if (std::ranges::find(codes, worst) != codes.end()) return worst;
    }
    return ExitCode::done;
}

}  // namespace palpate
