// The command line: parses, runs, maps errors to exit codes.
#include <fcntl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <iostream>
#include <optional>

#include "devices/version.h"
#include "tools/commands/commands.h"
#include "tools/commands/usage.h"
#include "tools/formats/export_format.h"
#include "tools/session_files.h"
#include "tools/terminal/log.h"
#include "tools/terminal/text_width.h"

// A port that is opened must not become standard input, output or error because somebody had closed those.
static void occupy_standard_streams() {
    int file = 0;
    while (file >= 0 && file <= STDERR_FILENO) file = open("/dev/null", O_RDWR);
    if (file > STDERR_FILENO) close(file);
}

// While it lives a stream writes to another buffer.
class StreamFor {
public:
    StreamFor(std::ostream& stream, std::streambuf* buffer) : stream_(stream), before_(stream.rdbuf(buffer)) {
        stream_ << std::nounitbuf;  // by lines
    }
    ~StreamFor() {
        stream_.flush();
        stream_.rdbuf(before_);
    }
    StreamFor(const StreamFor&) = delete;
    StreamFor& operator=(const StreamFor&) = delete;
    StreamFor(StreamFor&&) = delete;
    StreamFor& operator=(StreamFor&&) = delete;

private:
    std::ostream& stream_;
    std::streambuf* before_;
};

// Output that waits in a buffer is not written yet. Throws OutputError.
static void flush_output() {
    std::cout.flush();
    if (!std::cout) throw palpate::OutputError("standard output cannot be written: is the disk full, or the reader gone?");
}

int main(int argc, char** argv) {
    using namespace palpate;
    occupy_standard_streams();
    // A full disk and a reader that is gone are errors like others, not the end of a process that moves a machine.
    std::signal(SIGXFSZ, SIG_IGN);
    std::signal(SIGPIPE, SIG_IGN);
    // Nothing that is said may hold up what moves: everything for standard error goes through a console.
    Console console(STDERR_FILENO);
    ConsoleStream console_stream(console);
    const StreamFor redirected(std::cerr, console_stream.buffer());
    Output output{std::cout, console};
    output.columns = columns_of(STDOUT_FILENO);
    log_to(output);

    CLI::App app("Palpate discovers the shape of an unknown solid by touching it.", "palpate");
    app.require_subcommand(1);
    app.failure_message(explain_usage);
    app.set_version_flag("--version", std::string(program_version()));
    app.footer(
        "Examples:\n"
        "  palpate simulate config/examples/bunny.yaml -o bunny --up y\n"
        "  palpate check my_part.yaml\n"
        "  palpate probe my_part.yaml -o my_part\n"
        "  palpate resume my_part\n"
        "  palpate continue my_part -o my_part_fine --tolerance 0.02\n"
        "  palpate bench config/examples/torus.yaml --strategy thesis,default\n"
        "Exit codes: 0 done, 1 internal error, 2 bad usage or configuration, 3 device fault, 4 incomplete result,\n"
        "5 a premise that was given is refuted, 6 an inspected part is out of tolerance.\n"
        "Every key of a configuration: config/README.md.");

    const auto add_overrides = [](CLI::App* command, std::vector<std::string>& overrides) {
        command->add_option("--set", overrides, "Override a key of the configuration, e.g. --set probing.epsilon=0.1; may be given again")
            ->type_name("KEY=VALUE")
            ->expected(1)
            ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    };

    const auto add_folder = [](CLI::App* command, std::filesystem::path& folder) {
        command->add_option("-o,--output", folder, "Session folder to write")->required()->type_name("DIR")->check(explain_option_as_name);
    };

    std::string up = "z";
    const auto add_up = [&up](CLI::App* command) {
        command->add_option("--up", up, "Axis that points up in the picture")->check(CLI::IsMember({"x", "y", "z"}))->capture_default_str();
    };
    bool no_picture = false;
    const auto add_picture = [&](CLI::App* command) {
        add_up(command);
        command->add_flag("--no-picture", no_picture, "Draw no picture; `palpate picture DIR` can do it later");
    };

    bool events = false;
    const auto add_loudness = [&](CLI::App* command) {
        command->add_flag("--quiet", output.is_quiet, "No progress, and of messages only warnings and errors");
        command->add_flag("--json", events, "One JSON object per line and event on standard output, in place of text");
    };

    SimulateCommand simulate;
    CLI::App* const simulate_app =
        app.add_subcommand("simulate", "Probe a hidden object blind, by ray casting, and write a session folder");
    simulate_app->add_option("CONFIG", simulate.config, "Configuration, YAML")->required();
    add_folder(simulate_app, simulate.folder);
    simulate_app->add_flag("--force", simulate.force, "Replace a session that is already in DIR");
    add_picture(simulate_app);
    add_overrides(simulate_app, simulate.overrides);
    add_loudness(simulate_app);
    simulate_app->footer("Example: palpate simulate config/examples/bunny.yaml -o bunny --up y --set probing.epsilon=0.5");

    const auto add_yes = [](CLI::App* command, bool& yes) {
        command->add_flag("--yes", yes, "Agree in advance that the machine moves: for unattended use");
    };

    ProbeCommand probe;
    CLI::App* const probe_app = app.add_subcommand("probe", "Probe a part with a machine, and write a session folder");
    probe_app->add_option("CONFIG", probe.config, "Configuration with a machine, YAML")->required();
    add_folder(probe_app, probe.folder);
    add_yes(probe_app, probe.yes);
    add_picture(probe_app);
    add_overrides(probe_app, probe.overrides);
    add_loudness(probe_app);
    probe_app->footer("Example: palpate probe my_part.yaml -o my_part\nCtrl-C stops the machine, and `palpate resume my_part` goes on.");

    ResumeCommand resume;
    CLI::App* const resume_app = app.add_subcommand("resume", "Go on with a session that was interrupted");
    resume_app->add_option("DIR", resume.folder, "Session folder")->required();
    resume_app->add_flag("--replay", resume.replay, "Make the files of a finished session again, from its journal, without a machine");
    add_yes(resume_app, resume.yes);
    resume_app->add_flag("--salvage", resume.salvage, "Go on from what is before the first damage of the journal; the damaged one is kept");
    add_overrides(resume_app, resume.overrides);
    add_loudness(resume_app);
    add_picture(resume_app);
    resume_app->footer(
        "Example: palpate resume my_part\n         palpate resume my_part --set machine.grbl.port=/dev/ttyUSB1\n         palpate resume "
        "--replay my_part\n"
        "Only how the machine is reached and homed may be overridden, and the budget raised: a session goes on as it began.");

    ContinueCommand going_on;
    CLI::App* const continue_app =
        app.add_subcommand("continue", "Go on from the touches of a session, finer or with a tolerance, in a new session folder");
    continue_app->add_option("DIR", going_on.earlier, "Folder of a session, finished or stopped, on a machine or simulated")->required();
    add_folder(continue_app, going_on.folder);
    continue_app->add_option("--tolerance", going_on.tolerance, "probing.tolerance of the new session, mm")
        ->check(CLI::PositiveNumber)
        ->type_name("MM");
    continue_app->add_option("--epsilon", going_on.epsilon, "probing.epsilon of the new session, mm")
        ->check(CLI::PositiveNumber)
        ->type_name("MM");
    continue_app->add_option("--box", going_on.box, "Both in this box alone, mm: its lowest and its highest corner")
        ->delimiter(',')
        ->expected(6)
        ->type_name("X,Y,Z X,Y,Z");
    continue_app->add_flag("--force", going_on.force, "Replace a simulated session that is already in the output folder");
    add_yes(continue_app, going_on.yes);
    add_overrides(continue_app, going_on.overrides);
    add_loudness(continue_app);
    add_picture(continue_app);
    continue_app->footer(
        "Example: palpate continue bunny -o bunny_fine --tolerance 0.1\n"
        "         palpate continue my_part -o my_part_boss --epsilon 0.5 --box 10,10,0 30,25,12\n"
        "Nothing that was touched is touched again but three places, which show that the part is where it was. The session that is gone on "
        "from stays as it is.");

    PictureCommand picture;
    CLI::App* const picture_app = app.add_subcommand("picture", "Draw the picture of a session again, from its mesh.ply");
    picture_app->add_option("DIR", picture.folder, "Session folder")->required();
    add_up(picture_app);
    picture_app->footer("Example: palpate picture bunny --up y");

    ExportCommand exported;
    CLI::App* const export_app = app.add_subcommand("export", "Write a session's result as other programs read it");
    export_app->add_option("DIR", exported.folder, "Session folder")->required();
    export_app->add_option("FILE", exported.file, "File to write")->required();
    export_app->add_option("--format", exported.format, "Where the extension does not say it: " + export_format_names());
    export_app->add_option("--mesh", exported.mesh, "part: mesh.ply; tool: what the tool's centre traces; surface: the curved surface")
        ->check(CLI::IsMember({"part", "tool", "surface"}))
        ->capture_default_str();
    export_app->add_option("--sections", exported.sections, "Heights of level sections, mm; for DXF")->delimiter(',')->type_name("Z,...");
    export_app->add_option("--step", exported.step, "Of a height map, mm; else a 50th of its longer side")->check(CLI::PositiveNumber);
    export_app->add_option("--window", exported.window, "Of a height map, mm; else around all")
        ->delimiter(',')
        ->expected(4)
        ->type_name("X0,Y0,X1,Y1");
    export_app->add_option("--missing", exported.missing, "Height of a height map's nodes beside the surface, mm")->type_name("Z");
    export_app->add_flag("--force", exported.force, "Replace the file if it is there");
    export_app->footer(
        "Examples: palpate export bunny bunny.stl; palpate export part part.dxf --sections 1,5; palpate export part part.probe --window "
        "2,2,8,8\n"
        "Files: .ply .stl .obj .off .3mf .vtp; .xyz and .csv: points with normals; .dxf: level sections; height maps: .probe (bCNC), "
        ".hmap\n"
        "(OpenCNCPilot), .map (Candle), --format ugs.");

    InspectCommand inspect;
    CLI::App* const inspect_app = app.add_subcommand("inspect", "Compare a session's result with a reference mesh");
    inspect_app->add_option("DIR", inspect.folder, "Session folder")->required();
    inspect_app->add_option("--against", inspect.reference, "Closed mesh of the reference: OFF, PLY, OBJ, STL")
        ->required()
        ->type_name("MESH");
    inspect_app->add_option("--scale", inspect.scale, "mm per unit of the reference")->check(CLI::PositiveNumber)->capture_default_str();
    inspect_app->add_option("--mesh", inspect.mesh, "part: mesh.ply; surface: the curved surface")
        ->check(CLI::IsMember({"part", "surface"}))
        ->capture_default_str();
    inspect_app->add_flag("--align", inspect.align, "Turn and move the result to where it fits best; else it lies as it was probed");
    inspect_app->add_option("--tolerance", inspect.tolerance, "Exit code 6 if a sample lies farther off, mm")->check(CLI::PositiveNumber);
    inspect_app->add_option("-o,--output", inspect.table, "Deviation of every sample, CSV: x, y, z, deviation (mm, outside is positive)");
    inspect_app->add_flag("--force", inspect.force, "Replace that file if it is there");
    inspect_app->footer("Example: palpate inspect part --against model.stl --align --tolerance 0.05 -o deviations.csv");

    TouchCommand touch;
    CLI::App* const touch_app = app.add_subcommand("touch", "One guarded touch: go to a place, probe towards another, come back");
    touch_app->add_option("CONFIG", touch.config, "Configuration with a machine, YAML")->required();
    touch_app->add_option("--from", touch.from, "Where it begins, mm")->required()->delimiter(',')->expected(3)->type_name("X,Y,Z");
    touch_app->add_option("--to", touch.to, "Where it ends at the latest, mm")->required()->delimiter(',')->expected(3)->type_name("X,Y,Z");
    add_yes(touch_app, touch.yes);
    add_overrides(touch_app, touch.overrides);
    touch_app->footer("Example: palpate touch my_part.yaml --from 3,0,11 --to 3,0,-2");

    CalibrateCommand calibrate;
    CLI::App* const calibrate_app =
        app.add_subcommand("calibrate", "Qualify the probe on a reference sphere: effective radius, lobes, repeatability");
    calibrate_app->add_option("CONFIG", calibrate.config, "Configuration with a machine and a tool, YAML")->required();
    calibrate_app->add_option("--sphere", calibrate.sphere, "Where the sphere's centre is, to within 0.8 mm")
        ->required()
        ->delimiter(',')
        ->expected(3)
        ->type_name("X,Y,Z");
    calibrate_app->add_option("--diameter", calibrate.diameter, "The sphere's, mm, as its certificate says")
        ->required()
        ->check(CLI::PositiveNumber);
    calibrate_app->add_option("-o,--output", calibrate.output, "Calibration to write; without it CONFIG.calibration.json beside CONFIG")
        ->type_name("FILE")
        ->check(explain_option_as_name);
    calibrate_app->add_option("--touches", calibrate.touches, "Places that are touched for the map")
        ->check(CLI::Range(25, 50))
        ->capture_default_str();
    calibrate_app->add_flag("--write", calibrate.write, "Have CONFIG name the calibration, in tool.calibration");
    add_yes(calibrate_app, calibrate.yes);
    add_overrides(calibrate_app, calibrate.overrides);
    calibrate_app->footer(
        "Example: palpate calibrate my_machine.yaml --sphere 80,-60,25 --diameter 25.4\n"
        "         palpate calibrate my_machine.yaml --sphere 80,-60,25 --diameter 25.4 --write --yes\n"
        "Move the tool above the sphere first: it goes straight there, guarded. An older calibration is replaced.");

    SetupCommand setup;
    CLI::App* const setup_app =
        app.add_subcommand("setup", "Touch the table and around the part, and put workspace, table and seed rays into a configuration");
    setup_app->add_option("CONFIG", setup.config, "Configuration with a machine and a tool, YAML")->required();
    setup_app->add_option("--table", setup.table, "Three places to touch the table at, mm; without it near the corners of machine.limits")
        ->delimiter(',')
        ->expected(6)
        ->type_name("X,Y X,Y X,Y");
    setup_app->add_option("--around", setup.around, "Touch the part from its sides at this height of the ball's centre, mm, and from above")
        ->type_name("Z");
    setup_app->add_option("--box", setup.box, "The part's corners, lowest and highest, mm; it is touched from above alone")
        ->delimiter(',')
        ->expected(6)
        ->type_name("X,Y,Z X,Y,Z")
        ->excludes("--around");
    setup_app->add_option("--center", setup.center, "A place on the part, mm; without it the middle of machine.limits, or of --box")
        ->delimiter(',')
        ->expected(2)
        ->type_name("X,Y");
    setup_app->add_option("--margin", setup.margin, "Between part and ball and the workspace's faces, mm; without it 6 x probing.epsilon")
        ->check(CLI::PositiveNumber);
    setup_app->add_flag("--yes", setup.yes, "Agree in advance that the machine moves and CONFIG is changed: for unattended use");
    add_overrides(setup_app, setup.overrides);
    setup_app->footer(
        "Example: palpate setup my_part.yaml --around 8\n"
        "         palpate setup my_part.yaml --table -60,-60 60,-60 0,60 --box -20,-15,0 20,15,30 --yes\n"
        "Move the tool above everything that stands on the table first: it goes from place to place at that height.");

    ConformanceCommand conformance;
    CLI::App* const conformance_app = app.add_subcommand(
        "conformance",
        "Try on a machine, without a part, whether it and its driver do what a session relies on, and say in words what is wrong");
    conformance_app->add_option("CONFIG", conformance.config, "Configuration with a machine, YAML")->required();
    conformance_app->add_option("--reach", conformance.reach, "So far the tool moves from where it stands, mm")->capture_default_str();
    conformance_app->add_flag("!--no-hand", conformance.hand, "Nobody is there to press the probe: what needs it is not tried");
    add_yes(conformance_app, conformance.yes);
    add_overrides(conformance_app, conformance.overrides);
    conformance_app->footer(
        "Example: palpate conformance my_machine.yaml --reach 20\n"
        "Exit code 3 if anything is bad. A program of your own (machine.external) is what it was made for; it goes for every machine.");

    CLI::App* const ports_app = app.add_subcommand("ports", "List the serial ports of this computer and what hangs on them");
    ports_app->footer("Example: palpate ports");

    VmCommand vm;
    CLI::App* const vm_app = app.add_subcommand("vm", "Run a virtual machine that hides a part, until Ctrl-C");
    vm_app->add_option("CONFIG", vm.config, "Configuration with a machine, YAML")->required();
    vm_app->add_option("--object", vm.object, "Mesh of the part to hide; else the configuration's object, or a ring")->type_name("MESH");
    vm_app->add_option("--grbl", vm.grbl, "A GRBL controller; LINK will lead to its serial port, or tcp://127.0.0.1:PORT")
        ->type_name("LINK");
    vm_app->add_option("--modbus", vm.modbus, "A Modbus controller on TCP")->type_name("HOST:PORT");
    vm_app->add_option("--modbus-rtu", vm.modbus_rtu, "A Modbus controller on a serial line; LINK will lead to it")->type_name("LINK");
    vm_app->add_option("--external", vm.external, "A program that drives a machine (machine.external.address)")->type_name("HOST:PORT");
    vm_app->add_option("--dialect", vm.dialect, "Firmware of the GRBL controller")
        ->check(CLI::IsMember({"grbl", "grblhal", "fluidnc"}))
        ->capture_default_str();
    vm_app->add_flag("--locked", vm.locked, "Start in alarm, as after power-on");
    vm_app->add_flag("--fast", vm.fast, "Motion takes no time");
    vm_app->add_option("--spurious", vm.spurious, "Share of the moves that trigger falsely")
        ->check(CLI::Range(0.0, 1.0))
        ->capture_default_str();
    vm_app->add_option("--bounce", vm.bounce, "Share of the touches that bounce")->check(CLI::Range(0.0, 1.0))->capture_default_str();
    vm_app->add_option("--miss", vm.miss, "Share of the touches that do not close the probe")
        ->check(CLI::Range(0.0, 1.0))
        ->capture_default_str();
    vm_app->add_option("--seed", vm.seed, "Of these three")->capture_default_str();
    vm_app->add_option("--audit", vm.audit, "Write what the machine saw of its motion to FILE, at the end")->type_name("FILE");
    add_overrides(vm_app, vm.overrides);
    vm_app->footer(
        "Example: palpate vm config/machines/grbl.yaml --grbl /tmp/palpate.tty &\n"
        "         palpate probe config/machines/grbl.yaml --set machine.grbl.port=/tmp/palpate.tty -o part --yes\n"
        "         kill -USR1 PID presses its probe for a second, as an operator does by hand");

    CheckCommand check;
    CLI::App* const check_app =
        app.add_subcommand("check", "Read a configuration and its object, connect to its machine, say what they mean, move nothing");
    check_app->add_option("CONFIG", check.config, "Configuration, YAML")->required();
    check_app->add_flag("--offline", check.offline, "Do not connect to the machine");
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
        ->check(explain_option_as_name)
        ->capture_default_str();
    bench_app->add_flag("--force", bench.force, "Replace these files if they are there");
    bench_app->add_flag(
        "--anytime", bench.anytime,
        "Write the error against probes and displacement, beside a z-raster, random rays and a Gaussian process: FILE.csv and FILE.svg; "
        "one CONFIG");
    bench_app->add_flag("--reliability", bench.reliability,
                        "Write how often plausible facets are wrong, over how often they are stated to be: FILE.csv and FILE.svg");
    add_overrides(bench_app, bench.overrides);
    bench_app->footer(
        "Example: palpate bench config/examples/*.yaml --strategy thesis,eager+exhaustive,default -o comparison\n"
        "         palpate bench config/examples/torus.yaml --anytime -o torus_anytime\n"
        "         palpate bench config/examples/*.yaml --strategy adaptive --reliability -o reliability");

    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (app.exit(error) != 0) return static_cast<int>(ExitCode::usage);
        // Help or the version was asked for.
        try {
            flush_output();
            return static_cast<int>(ExitCode::done);
        } catch (...) {
            return static_cast<int>(explain_current_exception(output));
        }
    }
    std::optional<Console> event_console;
    if (events)
        output.events = &event_console.emplace(
            STDOUT_FILENO, [](std::uint64_t count) { return "{\"event\":\"lost\",\"lines\":" + std::to_string(count) + "}\n"; });
    log_to(output);
    try {
        ExitCode code = ExitCode::done;
        if (*simulate_app) {
            simulate.picture = {!no_picture, up[0]};
            code = run(simulate, output);
        } else if (*probe_app) {
            probe.picture = {!no_picture, up[0]};
            code = run(probe, output);
        } else if (*resume_app) {
            resume.picture = {!no_picture, up[0]};
            code = run(resume, output);
        } else if (*continue_app) {
            going_on.picture = {!no_picture, up[0]};
            code = run(going_on, output);
        } else if (*export_app) {
            code = run(exported, output);
        } else if (*inspect_app) {
            code = run(inspect, output);
        } else if (*picture_app) {
            picture.up = up[0];
            code = run(picture, output);
        } else if (*touch_app) {
            code = run(touch, output);
        } else if (*calibrate_app) {
            code = run(calibrate, output);
        } else if (*setup_app) {
            code = run(setup, output);
        } else if (*conformance_app) {
            code = run(conformance, output);
        } else if (*ports_app) {
            code = run(PortsCommand{}, output);
        } else if (*vm_app) {
            code = run(vm, output);
        } else if (*check_app) {
            code = run(check, output);
        } else {
            code = run(bench, output);
        }
        flush_output();
        return static_cast<int>(code);
    } catch (...) {
        return static_cast<int>(explain_current_exception(output));
    }
}
