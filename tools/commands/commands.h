// What each subcommand of `palpate` does, once its words are understood. Exit codes are those of planner/DESIGN.md, "Session folder".
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/results.h"
#include "tools/terminal/output.h"

namespace palpate {

struct Result;

// Stable, for scripts.
enum class ExitCode : int {
    done = 0,              // certified, or certified as far as assumed
    internal = 1,          // a bug of ours
    usage = 2,             // bad usage, configuration, object or folder
    device = 3,            // device fault, resumable
    incomplete = 4,        // the result does not fulfil what it has to
    refuted = 5,           // it does, but touches contradict what the user vouched for
    out_of_tolerance = 6,  // a part that was inspected
};

struct SimulateCommand {
    std::filesystem::path config;
    std::filesystem::path folder;
    std::vector<std::string> overrides;
    bool force = false;
    PictureChoice picture;
};
struct CheckCommand {
    std::filesystem::path config;
    std::vector<std::string> overrides;
    bool offline = false;  // do not connect to the machine
};
struct ProbeCommand {
    std::filesystem::path config;
    std::filesystem::path folder;
    std::vector<std::string> overrides;
    bool yes = false;  // the operator agrees in advance that the machine moves
    PictureChoice picture;
};
struct ResumeCommand {
    std::filesystem::path folder;
    std::vector<std::string> overrides;  // how the machine is reached now
    bool replay = false;                 // from the journal alone, without a machine
    bool salvage = false;                // from what is before the first damage of its journal
    bool yes = false;
    PictureChoice picture;
};
struct ContinueCommand {
    std::filesystem::path earlier;  // folder of the session that is gone on from
    std::filesystem::path folder;
    std::optional<double> tolerance;  // mm
    std::optional<double> epsilon;    // mm
    std::vector<double> box;          // mm: x, y, z of two corners; both are for that box alone then
    std::vector<std::string> overrides;
    bool force = false;  // replace a simulated session that is there
    bool yes = false;
    PictureChoice picture;
};
struct PictureCommand {
    std::filesystem::path folder;
    char up = 'z';
};
struct ExportCommand {
    std::filesystem::path folder;
    std::filesystem::path file;
    std::string format;             // empty: as the file's extension says
    std::string mesh = "part";      // or tool, surface
    std::vector<double> sections;   // mm: heights, for DXF
    std::optional<double> step;     // mm: of a height map; none: a 50th of its longer side
    std::vector<double> window;     // mm: x, y of two corners; empty: around all
    std::optional<double> missing;  // mm: the height of what lies beside the surface
    bool force = false;             // replace a file that is there
};
struct InspectCommand {
    std::filesystem::path folder;
    std::filesystem::path reference;  // mesh
    double scale = 1.0;               // mm per unit of that
    std::string mesh = "part";        // or surface
    bool align = false;               // best fit first
    std::optional<double> tolerance;  // mm, either way
    std::filesystem::path table;      // CSV to write; empty: none
    bool force = false;
};
struct TouchCommand {
    std::filesystem::path config;
    std::vector<std::string> overrides;
    std::vector<double> from;  // mm, three each
    std::vector<double> to;
    bool yes = false;
};
struct CalibrateCommand {
    std::filesystem::path config;
    std::vector<std::string> overrides;
    std::vector<double> sphere;    // mm, three
    double diameter = 0.0;         // mm
    std::filesystem::path output;  // empty: CONFIG with another extension
    std::size_t touches = 50;      // for the map
    bool write = false;            // have the configuration name the calibration
    bool yes = false;
};
struct SetupCommand {
    std::filesystem::path config;
    std::vector<std::string> overrides;
    std::vector<double> table;     // mm: x, y of three touches; empty: near the corners of the limits
    std::optional<double> around;  // mm: height of the touches around the part; one of these two
    std::vector<double> box;       // mm: x, y, z of the part's lowest and highest corner
    std::vector<double> center;    // mm: x, y of a place on the part; empty: the middle of the box, or of the limits
    std::optional<double> margin;  // mm: between the part, as the ball touches it, and the workspace's faces; none: 6 epsilon
    bool yes = false;              // to moves, and to the change of the configuration
};
struct ConformanceCommand {
    std::filesystem::path config;
    std::vector<std::string> overrides;
    double reach = 10.0;  // mm: so far from where the tool stands
    bool hand = true;     // somebody is there to press the probe
    bool yes = false;
};
struct PortsCommand {};
struct VmCommand {
    std::filesystem::path config;
    std::vector<std::string> overrides;
    std::filesystem::path grbl;        // link to make, or tcp://HOST:PORT; one of these four
    std::string external;              // HOST:PORT
    std::string modbus;                // HOST:PORT
    std::filesystem::path modbus_rtu;  // link to make
    std::filesystem::path object;      // mesh of the part to hide; empty: the configuration's, or one of its own
    std::string dialect = "grbl";      // or grblhal, fluidnc
    bool locked = false;
    bool fast = false;
    double spurious = 0.0;  // share of the moves that trigger falsely
    double bounce = 0.0;    // share of the touches that bounce
    double miss = 0.0;      // share of the touches that do not close the probe
    std::uint64_t seed = 1;
    std::filesystem::path audit;  // where the account of motion goes; standard output if empty
};
struct BenchCommand {
    std::vector<std::filesystem::path> configs;
    std::vector<std::string> strategies;
    std::filesystem::path output;  // without extension
    std::vector<std::string> overrides;
    bool force = false;        // replace output that is there
    bool anytime = false;      // errors before the end instead of the table
    bool reliability = false;  // how often plausible facets are wrong instead of the table
};

// They throw what the parts throw.
ExitCode run(const SimulateCommand& command, Output& output);
ExitCode run(const CheckCommand& command, Output& output);
ExitCode run(const BenchCommand& command, Output& output);
ExitCode run(const ProbeCommand& command, Output& output);
ExitCode run(const ResumeCommand& command, Output& output);
ExitCode run(const ContinueCommand& command, Output& output);
ExitCode run(const PictureCommand& command, Output& output);
ExitCode run(const ExportCommand& command, Output& output);
ExitCode run(const InspectCommand& command, Output& output);
ExitCode run(const TouchCommand& command, Output& output);
ExitCode run(const CalibrateCommand& command, Output& output);
ExitCode run(const SetupCommand& command, Output& output);
ExitCode run(const ConformanceCommand& command, Output& output);
ExitCode run(const PortsCommand& command, Output& output);
ExitCode run(const VmCommand& command, Output& output);

// Of a run that came to its end.
[[nodiscard]] ExitCode exit_code_of(const Result& result);
// Says on standard error what the exception in flight means, in one message, and gives the exit code for it. REQUIRES:
// called in a catch block.
ExitCode explain_current_exception(Output& output);

}  // namespace palpate
