// What each subcommand of `palpate` does, once its words are understood. Exit codes are those of planner/DESIGN.md, "Session folder".
#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "tools/results.h"

namespace palpate {

struct Result;

// Stable, for scripts.
enum class ExitCode : int {
    done = 0,        // certified, or certified as far as assumed
    internal = 1,    // a bug of ours
    usage = 2,       // bad usage, configuration, object or folder
    device = 3,      // device fault, resumable
    incomplete = 4,  // the result does not fulfil what it has to
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
    bool yes = false;
    PictureChoice picture;
};
struct PictureCommand {
    std::filesystem::path folder;
    char up = 'z';
};
struct TouchCommand {
    std::filesystem::path config;
    std::vector<std::string> overrides;
    std::vector<double> from;  // mm, three each
    std::vector<double> to;
    bool yes = false;
};
struct PortsCommand {};
struct VmCommand {
    std::filesystem::path config;
    std::vector<std::string> overrides;
    std::filesystem::path grbl;        // link to make; one of these three
    std::string modbus;                // HOST:PORT
    std::filesystem::path modbus_rtu;  // link to make
    std::string dialect = "grbl";      // or grblhal
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
    bool force = false;    // replace output that is there
    bool anytime = false;  // errors before the end instead of the table
};

// Results go to `out`, progress, questions and warnings to standard error. They throw what the parts throw.
ExitCode run(const SimulateCommand& command, std::ostream& out);
ExitCode run(const CheckCommand& command, std::ostream& out);
ExitCode run(const BenchCommand& command, std::ostream& out);
ExitCode run(const ProbeCommand& command, std::ostream& out);
ExitCode run(const ResumeCommand& command, std::ostream& out);
ExitCode run(const PictureCommand& command, std::ostream& out);
ExitCode run(const TouchCommand& command, std::ostream& out);
ExitCode run(const PortsCommand& command, std::ostream& out);
ExitCode run(const VmCommand& command, std::ostream& out);

// Of a run that came to its end.
[[nodiscard]] ExitCode exit_code_of(const Result& result);
// Says on standard error what the exception in flight means, in one message, and gives the exit code for it. REQUIRES:
// called in a catch block.
ExitCode explain_current_exception();

}  // namespace palpate
