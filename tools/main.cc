// The command line: parses, runs, maps errors to exit codes.
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <iostream>

#include "tools/commands.h"
#include "tools/session_files.h"

int main(int argc, char** argv) {
    using namespace palpate;
    const auto log = spdlog::stderr_color_mt("palpate");
    log->set_pattern("%n: %^%l%$: %v");
    spdlog::set_default_logger(log);

    CLI::App app("Palpate discovers the shape of an unknown solid by touching it.", "palpate");
    app.require_subcommand(1);
    app.set_version_flag("--version", PALPATE_VERSION);
    app.footer(
        "Examples:\n"
        "  palpate simulate config/examples/bunny.yaml -o bunny --up y\n"
        "  palpate check my_part.yaml\n"
        "  palpate bench config/examples/torus.yaml --strategy thesis,default\n"
        "Exit codes: 0 done, 1 internal error, 2 bad usage or configuration, 3 device fault, 4 incomplete result.\n"
        "Every key of a configuration: config/README.md.");

    const auto add_overrides = [](CLI::App* command, std::vector<std::string>& overrides) {
        command->add_option("--set", overrides, "Override a key of the configuration, e.g. --set probing.epsilon=0.1; may be given again")
            ->type_name("KEY=VALUE")
            ->expected(1)
            ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    };

    SimulateCommand simulate;
    CLI::App* const simulate_app =
        app.add_subcommand("simulate", "Probe a hidden object blind, by ray casting, and write a session folder");
    simulate_app->add_option("CONFIG", simulate.config, "Configuration, YAML")->required();
    simulate_app->add_option("-o,--output", simulate.folder, "Session folder to write")->required()->type_name("DIR");
    simulate_app->add_flag("--force", simulate.force, "Replace a session that is already in DIR");
    std::string up = "z";
    simulate_app->add_option("--up", up, "Axis that points up in the picture")
        ->check(CLI::IsMember({"x", "y", "z"}))
        ->capture_default_str();
    add_overrides(simulate_app, simulate.overrides);
    simulate_app->footer("Example: palpate simulate config/examples/bunny.yaml -o bunny --up y --set probing.epsilon=0.5");

    CheckCommand check;
    CLI::App* const check_app = app.add_subcommand("check", "Read a configuration and its object, say what they mean, move nothing");
    check_app->add_option("CONFIG", check.config, "Configuration, YAML")->required();
    add_overrides(check_app, check.overrides);
    check_app->footer("Example: palpate check config/examples/torus.yaml");

    BenchCommand bench;
    bench.strategies = {"thesis", "default"};
    bench.output = "bench";
    CLI::App* const bench_app = app.add_subcommand("bench", "Probe the same objects with several strategies and compare");
    bench_app->add_option("CONFIG", bench.configs, "Configurations, YAML")->required();
    bench_app
        ->add_option("--strategy", bench.strategies, "Strategies: default, thesis, adaptive, or refine+explore such as eager+exhaustive")
        ->delimiter(',')
        ->capture_default_str();
    bench_app->add_option("-o,--output", bench.output, "Write FILE.csv and FILE.json, or FILE.svg")
        ->type_name("FILE")
        ->capture_default_str();
    bench_app->add_flag("--force", bench.force, "Replace these files if they are there");
    bench_app->add_flag("--anytime", bench.anytime,
                        "Write the error against probes and displacement, beside a z-raster and random rays: FILE.csv and FILE.svg; "
                        "one CONFIG");
    add_overrides(bench_app, bench.overrides);
    bench_app->footer(
        "Example: palpate bench config/examples/*.yaml --strategy thesis,eager+exhaustive,default -o comparison\n"
        "         palpate bench config/examples/torus.yaml --anytime -o torus_anytime");

    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : static_cast<int>(ExitCode::usage);
    }
    try {
        ExitCode code = ExitCode::done;
        if (*simulate_app) {
            simulate.up = up[0];
            code = run(simulate, std::cout);
        } else if (*check_app) {
            code = run(check, std::cout);
        } else {
            code = run(bench, std::cout);
        }
        std::cout.flush();
        if (!std::cout) throw OutputError("standard output cannot be written: is the disk full, or the reader gone?");
        return static_cast<int>(code);
    } catch (...) {
        return static_cast<int>(explain_current_exception());
    }
}
