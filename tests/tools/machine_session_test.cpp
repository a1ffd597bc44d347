// Sessions are killed, stopped, unplugged and resumed. The machine's own account says whether anything moved that must not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "devices/session/journal.h"
#include "sim/machines/external/virtual_program.h"
#include "sim/machines/modbus/virtual_modbus.h"
#include "sim/machines/pseudo_terminal.h"
#include "sim/truth.h"
#include "tests/random.h"
#include "tests/tools/session_rig.h"
#include "tools/provenance.h"

namespace palpate::machine_session_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

class MachineSession : public SessionRig {
protected:
    [[nodiscard]] TriangleMesh read_mesh(const fs::path& file) const {
        std::istringstream in(read(file));
        std::string word;
        std::size_t points = 0;
        std::size_t triangles = 0;
        while (in >> word && word != "end_header") {
            if (word == "vertex") in >> points;
            if (word == "face") in >> triangles;
        }
        TriangleMesh mesh;
        mesh.points.resize(points);
        for (Point& p : mesh.points) in >> p.x() >> p.y() >> p.z();
        mesh.triangles.resize(triangles);
        for (auto& [a, b, c] : mesh.triangles) in >> word >> a >> b >> c;
        EXPECT_TRUE(in) << file;
        return mesh;
    }

    // Wherever the machine is.
    [[nodiscard]] static std::vector<std::string> with_port(std::vector<std::string> words, PortMachine& machine) {
        if (!is_tcp_address(machine.host().client_path())) return words;
        words.insert(words.end(), {"--set", "machine.grbl.port=" + machine.host().client_path()});
        return words;
    }
    // An uninterrupted session, and what its machine had to do.
    void run_reference(const VirtualGrblOptions& options = {}) {
        PortMachine machine(port(), options);
        ASSERT_EQ(run(probe("reference")), 0) << read("out.txt");
        expect_safe(machine);
        probes_ = machine.probes();
        mesh_ = read("reference/mesh.ply");
        moves_ = read_journal(folder_ / "reference/journal.jsonl").moves;
        ASSERT_GT(probes_, 100U);
    }
    // A configuration that names another port has another digest.
    [[nodiscard]] static std::string without_digest(std::string mesh) {
        const std::size_t line = mesh.find("comment configuration:");
        return line == std::string::npos ? mesh : mesh.erase(line, mesh.find('\n', line) + 1 - line);
    }
    // The same mesh, from the same answers to the same questions: nothing lost, nothing false, nothing asked twice.
    void expect_same(const std::string& session, const fs::path& line = {}) const {
        const std::string mesh = read(session + "/mesh.ply");
        EXPECT_TRUE(mesh == mesh_ || (line == kNetwork && without_digest(mesh) == without_digest(mesh_))) << session;
        const Journal journal = read_journal(folder_ / session / "journal.jsonl");
        ASSERT_EQ(journal.moves.size(), moves_.size());
        for (std::size_t k = 0; k < moves_.size(); ++k) {
            ASSERT_EQ(journal.moves[k].target, moves_[k].target) << k;
            ASSERT_EQ(journal.moves[k].result.outcome, moves_[k].result.outcome) << k;
            ASSERT_EQ(journal.moves[k].result.position, moves_[k].result.position) << k;
        }
    }

    std::uint64_t probes_ = 0;
    std::string mesh_;
    std::vector<JournalMove> moves_;
};

TEST_F(MachineSession, FindsTheSameTopologyOnEveryMachine) {
    for (const GrblDialect dialect : {GrblDialect::grbl, GrblDialect::grblhal}) {
        VirtualGrblOptions options;
        options.dialect = dialect;
        options.locked = true;  // homing is on its way
        PortMachine machine(port(), options);
        const std::string session = dialect == GrblDialect::grbl ? "grbl" : "grblhal";
        ASSERT_EQ(run(probe(session)), 0) << read("out.txt");
        expect_safe(machine);
    }
    for (const GrblDialect dialect : {GrblDialect::grbl, GrblDialect::grblhal}) {
        VirtualGrblOptions options;
        options.dialect = dialect;
        options.locked = true;
        PortMachine machine(kNetwork, options);
        const std::string session = dialect == GrblDialect::grbl ? "grbl_tcp" : "grblhal_tcp";
        ASSERT_EQ(run(with_port(probe(session), machine)), 0) << read("out.txt");
        expect_safe(machine);
        EXPECT_EQ(without_digest(read(session + "/mesh.ply")), without_digest(read("grbl/mesh.ply")));
    }
    const HiddenObject object(ShapeSpec{SphereSpec{kRadius}});
    for (const bool serial : {false, true}) {
        VirtualModbusOptions options;
        options.tool = axes();
        options.speedup = 500;
        std::variant<VirtualModbusTcp, VirtualModbusSerial> where = VirtualModbusTcp{};
        if (serial) where = VirtualModbusSerial{folder_ / "line"};
        VirtualModbus modbus(object, options, where);
        const auto link = modbus.link().where;
        write("modbus.yaml", serial ? "modbus: {rtu: {path: " + (folder_ / "line").string() + ", baud: 115200}}"
                                    : "modbus: {tcp: {host: 127.0.0.1, port: " + std::to_string(std::get<ModbusTcp>(link).port) + "}}");
        const std::string session = serial ? "rtu" : "tcp";
        ASSERT_EQ(run({"probe", "modbus.yaml", "-o", session, "--yes", "--set", "probing.epsilon=3"}), 0) << read("out.txt");
        const VirtualToolAudit audit = modbus.with_controller([](const VirtualModbusController& c) { return c.tool().audit(); });
        EXPECT_EQ(audit.unguarded_moves + audit.outside_limits + audit.unsafe_moves, 0U);
    }
    {
        VirtualTool tool(object, axes());
        VirtualProgram program(tool, {});
        write("external.yaml", "external: {address: '" + program.address() + "'}");
        ASSERT_EQ(run({"probe", "external.yaml", "-o", "external", "--yes"}), 0) << read("out.txt");
        program.with([](VirtualTool& t) {
            EXPECT_GT(t.audit().moves, 100U);
            EXPECT_EQ(t.audit().unguarded_moves + t.audit().outside_limits + t.audit().unsafe_moves, 0U);
        });
    }
    for (const std::string session : {"grbl", "grblhal", "external", "tcp", "rtu"}) {
        // As far from the sphere as the direct run may be (planner/DESIGN.md, "Guarantees"), and the resolution.
        const double epsilon = session == "tcp" || session == "rtu" ? 3 : 2;
        EXPECT_LE(measure_truth(object, read_mesh(fs::path(session) / "mesh.ply"), TruthSampling{}, 1).hausdorff,
                  1.5 * epsilon * epsilon / kRadius + 0.002)
            << session;
        const auto summary = nlohmann::json::parse(read(fs::path(session) / "summary.json"));
        EXPECT_EQ(summary.at("euler_characteristic"), 2) << session;
        EXPECT_EQ(summary.at("components"), 1) << session;
        EXPECT_EQ(summary.at("boundary_edges"), 0) << session;
        EXPECT_EQ(summary.at("nonmanifold_edges"), 0) << session;
        EXPECT_NE(summary.at("certificate").at("status"), "refuted") << session;
        // Every touch lies on the sphere, up to resolution and rounding both ways.
        std::istringstream touches(read(fs::path(session) / "touches.csv"));
        std::string line;
        std::getline(touches, line);
        while (std::getline(touches, line)) {
            std::istringstream fields(line);
            std::string field;
            Point p;
            std::getline(fields, field, ',');
            for (int axis = 0; axis < 3; ++axis) {
                std::getline(fields, field, ',');
                p[axis] = std::stod(field);
            }
            ASSERT_NEAR(p.norm(), kRadius, 0.003) << session << ": " << line;
        }
    }
    EXPECT_EQ(read("grbl/mesh.ply"), read("grblhal/mesh.ply"));
}

class KilledSession : public MachineSession {
protected:
    // `line`: what the machine is on; empty: now this, now that.
    void kill_at_random_moments(int times, const fs::path& line = {});
};

void KilledSession::kill_at_random_moments(int times, const fs::path& line) {
    constexpr std::uint64_t kSeed = 2026;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    const auto begin = std::chrono::steady_clock::now();
    ASSERT_NO_FATAL_FAILURE(run_reference());
    const std::chrono::duration<double> whole = std::chrono::steady_clock::now() - begin;
    int kills = 0;
    for (int session = 0; kills < times; ++session) {
        const fs::path where = !line.empty() ? line : session % 2 == 0 ? port() : kNetwork;
        PortMachine machine(where);
        const std::string name = "killed_" + std::to_string(session);
        std::uint64_t resumptions = 0;
        for (bool is_first = true;; is_first = false) {
            Process process =
                start(with_port(is_first || !fs::exists(folder_ / name / "journal.jsonl") ? probe(name) : resume(name), machine));
            const bool ends = kills >= times || resumptions > 12;
            if (!ends) {
                std::this_thread::sleep_for(random.uniform(0, 0.3) * whole);
                process.send(SIGKILL);
            }
            const int code = process.wait();
            if (code == 0) break;
            ASSERT_EQ(code, 128 + SIGKILL) << read("out.txt");
            ++kills;
            ++resumptions;
            // A session that was killed before it began has only a configuration.
            if (!fs::exists(folder_ / name / "journal.jsonl")) {
                fs::remove_all(folder_ / name);
            } else if (fs::file_size(folder_ / name / "journal.jsonl") == 0) {
                fs::remove_all(folder_ / name);
            }
        }
        expect_same(name, where);
        expect_safe(machine);
        // Besides the answers that were lost with the process, only confirmations were touched again.
        const Journal journal = read_journal(folder_ / name / "journal.jsonl");
        EXPECT_LE(journal.resumptions.size(), resumptions);
        ASSERT_FALSE(HasFailure()) << name;
    }
    EXPECT_GE(kills, times);
}

TEST_F(KilledSession, EndsWithTheSameMesh) { kill_at_random_moments(30); }
TEST_F(KilledSession, NightlyAHundredTimes) { kill_at_random_moments(100); }
TEST_F(KilledSession, NightlyOnTheNetwork) { kill_at_random_moments(30, kNetwork); }

TEST_F(MachineSession, UnpluggedResetAlarmedOrSilentItIsResumedAndEndsWithTheSameMesh) {
    constexpr std::uint64_t kSeed = 7;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    ASSERT_NO_FATAL_FAILURE(run_reference());
    using Kind = VirtualFault::Kind;
    std::vector<VirtualFault> faults;
    for (const Kind kind : {Kind::hang_up, Kind::io_error, Kind::press_reset, Kind::silence})
        faults.push_back({kind, VirtualFault::When::probe, 0, 0, {}});
    for (const double alarm : {1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 9.0})
        faults.push_back({Kind::alarm, VirtualFault::When::probe, 0, alarm, {}});
    for (VirtualFault fault : faults) {
        fault.at = 1 + static_cast<double>(random.below(probes_ / 2));  // a fault on the way out again leaves the session finished
        SCOPED_TRACE("fault " + std::to_string(static_cast<int>(fault.kind)) + ", alarm " + std::to_string(fault.argument) + ", at probe " +
                     std::to_string(fault.at));
        VirtualGrblOptions options;
        options.faults = {fault};
        PortMachine machine(port(), options);
        const std::string name =
            "fault_" + std::to_string(static_cast<int>(fault.kind)) + "_" + std::to_string(static_cast<int>(fault.argument));
        const int code = run(probe(name));
        if (code == 0 && fault.argument == 4.0) {
            // On the way back from a touch the probe may bounce: nobody is asked to look at that.
            expect_same(name);
            expect_safe(machine);
            continue;
        }
        ASSERT_EQ(code, 3) << read("out.txt");
        EXPECT_THAT(read("out.txt"), HasSubstr("palpate resume " + name));
        if (fault.kind == Kind::hang_up || fault.kind == Kind::io_error) {
            machine.host().plug_in();
        } else {
            if (fault.kind == Kind::silence) machine.host().with([](VirtualGrbl& grbl) { grbl.press_reset(); });
            machine.move_out_by_hand();
        }
        ASSERT_EQ(run(resume(name)), 0) << read("out.txt");
        expect_same(name);
        expect_safe(machine);
    }
}

// A program that is gone in mid-session, as a robot's that crashed.
TEST_F(MachineSession, AProgramThatIsStartedAgainIsResumed) {
    const HiddenObject object(ShapeSpec{SphereSpec{kRadius}});
    const auto probe_with = [&](const VirtualProgramOptions& options, const std::vector<std::string>& words) {
        VirtualToolOptions there = axes();
        if (fs::exists(folder_ / "crashed/journal.jsonl"))
            there.start = kOrigin + read_journal(folder_ / "crashed/journal.jsonl").last_rest();
        VirtualTool tool(object, there);
        VirtualProgram program(tool, options);
        std::vector<std::string> all = words;
        all.insert(all.end(), {"--set", "machine.external.address='" + program.address() + "'"});
        const int code = run(all);
        program.with([](VirtualTool& t) { EXPECT_EQ(t.audit().unguarded_moves + t.audit().outside_limits + t.audit().unsafe_moves, 0U); });
        return code;
    };
    write("external.yaml", "external: {address: 'localhost:1'}");
    ASSERT_EQ(probe_with({}, {"probe", "external.yaml", "-o", "whole", "--yes"}), 0) << read("out.txt");
    for (const ProgramFault::Kind kind : {ProgramFault::Kind::hang_up, ProgramFault::Kind::silent}) {
        VirtualProgramOptions crashing;
        crashing.faults = {{kind, 61}};
        EXPECT_EQ(probe_with(crashing, {"probe", "external.yaml", "-o", "crashed", "--yes"}), 3) << read("out.txt");
        ASSERT_EQ(probe_with({}, {"resume", "crashed", "--yes"}), 0) << read("out.txt");
        EXPECT_EQ(read("crashed/touches.csv"), read("whole/touches.csv"));
        fs::remove_all(folder_ / "crashed");
    }
}

TEST_F(MachineSession, ConformanceIsSaidInWords) {
    PortMachine machine(port());
    write("tried.yaml", "grbl: {port: " + port().string() + "}\n  homing: run");
    EXPECT_EQ(run({"conformance", "tried.yaml", "--reach", "4", "--no-hand"}), 2) << "nobody agreed";
    EXPECT_EQ(machine.audit().moves, 0U);
    // It is in fast time.
    EXPECT_EQ(run({"conformance", "tried.yaml", "--reach", "4", "--no-hand", "--yes"}), 3) << read("out.txt");
    EXPECT_THAT(read("out.txt"), HasSubstr("good       goes where it is told: 24 moves"));
    EXPECT_THAT(read("out.txt"), HasSubstr("BAD        keeps its feeds: "));
    EXPECT_THAT(read("out.txt"), HasSubstr("not tried  ends a move at a touch, and draws back: nobody is there to press the probe"));
    expect_safe(machine);
}

TEST_F(MachineSession, ANetworkThatGoesAndComesIsResumed) {
    ASSERT_NO_FATAL_FAILURE(run_reference());
    VirtualGrblOptions options;
    options.faults = {{VirtualFault::Kind::hang_up, VirtualFault::When::probe, static_cast<double>(probes_ / 3), 0, {}}};
    PortMachine machine(kNetwork, options);
    const std::string address = machine.host().client_path();
    ASSERT_EQ(run(with_port(probe("away"), machine)), 3);
    EXPECT_THAT(read("out.txt"), HasSubstr(address + ": the connection is lost (the other side ended it)"));
    auto words = resume("away");
    words.insert(words.end(), {"--set", "machine.grbl.port=" + address});
    EXPECT_EQ(run(words), 3);
    EXPECT_THAT(read("out.txt"), HasSubstr(address + ": cannot be reached: nobody takes a connection there"));
    machine.host().plug_in();
    ASSERT_EQ(run(with_port(resume("away"), machine)), 0) << read("out.txt");
    expect_same("away", kNetwork);
    expect_safe(machine);
}

TEST_F(MachineSession, StoppedByTheOperatorItGoesBackAndIsResumed) {
    ASSERT_NO_FATAL_FAILURE(run_reference());
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        PortMachine machine(port());
        const std::string name = "stopped_" + std::to_string(signal);
        Process process = start(probe(name));
        wait_for_probes(machine, probes_ / 2);
        process.send(signal);
        EXPECT_EQ(process.wait(), 3);
        EXPECT_THAT(read("out.txt"), HasSubstr("stopped"));
        EXPECT_EQ(run(resume(name)), 0) << read("out.txt");
        expect_same(name);
        expect_safe(machine);
    }
}

// The known place is touched again no deeper than the limits allow.
TEST_F(MachineSession, AToleranceThatReachesBeyondTheLimitsIsNoReasonNotToResume) {
    PortMachine machine(port());
    auto words = probe("tolerant");
    words.insert(words.end(), {"--set", "machine.datum_tolerance=12"});
    Process process = start(words);
    wait_for_probes(machine, 60);
    process.send(SIGINT);
    EXPECT_EQ(process.wait(), 3);
    EXPECT_EQ(run(resume("tolerant")), 0) << read("out.txt");
    expect_safe(machine);
}

TEST_F(MachineSession, AMachineThatHasAnotherPortNowIsResumed) {
    ASSERT_NO_FATAL_FAILURE(run_reference());
    Point rest;
    {
        PortMachine machine(port());
        Process process = start(probe("renamed"));
        wait_for_probes(machine, 60);
        process.send(SIGINT);
        EXPECT_EQ(process.wait(), 3);
        rest = read_journal(folder_ / "renamed/journal.jsonl").last_rest();
    }
    VirtualToolOptions there = axes();
    there.start = kOrigin + rest;
    PortMachine machine(folder_ / "other_tty", {}, there);
    EXPECT_EQ(run(resume("renamed")), 3);
    auto words = resume("renamed");
    words.insert(words.end(), {"--set", "probing.epsilon=1"});
    EXPECT_EQ(run(words), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("a session goes on as it began"));
    words.back() = "machine.grbl.port=" + (folder_ / "other_tty").string();
    EXPECT_EQ(run(words), 0) << read("out.txt");
    expect_same("renamed");
    expect_safe(machine);
}

// ... in which no session can begin.
TEST_F(MachineSession, ASessionThatFindsNoSeedsLeavesNoToolInTheWorkspace) {
    PortMachine machine(port());
    auto words = probe("coarse");
    words.insert(words.end(), {"--set", "probing.epsilon=20", "--set", "probing.reach=null"});
    EXPECT_EQ(run(words), 2) << read("out.txt");
    EXPECT_EQ(run(probe("fine")), 0) << read("out.txt");
    expect_safe(machine);
}

TEST_F(MachineSession, CheckSaysWhatASessionWouldRefuse) {
    VirtualGrblOptions options;
    options.locked = true;
    PortMachine machine(port(), options);
    EXPECT_EQ(run({"check", "part.yaml"}), 0) << "it will be homed: " << read("out.txt");
    EXPECT_EQ(run({"check", "part.yaml", "--set", "machine.homing=require"}), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("ready: no  <- home it"));
    EXPECT_EQ(run({"check", "part.yaml", "--offline", "--set", "object.mesh=missing.off"}), 0) << "a machine has a part of its own";
    EXPECT_EQ(machine.audit().moves, 0U);
}

// Nobody knows what hangs on a silent port: what will be done to it is said before, and is so.
TEST_F(MachineSession, WhatConnectingMayDoIsSaidBefore) {
    PseudoTerminal silent(port());
    EXPECT_EQ(run({"check", "part.yaml"}), 3);
    const std::string said = read("out.txt");
    const std::size_t before = said.find("connecting to " + port().string() + ": opening it may reset what is on it");
    ASSERT_NE(before, std::string::npos) << said;
    EXPECT_THAT(said, HasSubstr("is sent a reset (Ctrl-X) twice"));
    EXPECT_THAT(said, HasSubstr("up to 8 s"));
    EXPECT_GT(said.find("nothing answers on " + port().string() + " within 8 s"), before);
    (void)silent.take_openings();
    const std::string sent = silent.read();
    EXPECT_GE(std::ranges::count(sent, '\x18'), 1);
    EXPECT_LE(std::ranges::count(sent, '\x18'), 2);
    EXPECT_EQ(sent.find_first_not_of("?\x18"), std::string::npos) << "no line was sent";
}

// Also when the silence has lasted so long that resets are sent.
TEST_F(MachineSession, AStopOnASilentPortEndsAtOnceAndSaysSo) {
    PseudoTerminal silent(port());
    Process probing = start(probe("mine"));
    std::string sent;
    while (sent.find('\x18') == std::string::npos) {
        std::this_thread::sleep_for(20ms);
        (void)silent.take_openings();
        sent += silent.read();
    }
    const auto asked = std::chrono::steady_clock::now();
    probing.send(SIGTERM);
    EXPECT_EQ(probing.wait(), 3);
    EXPECT_LT(std::chrono::steady_clock::now() - asked, 1s);
    EXPECT_THAT(read("out.txt"), HasSubstr("stopped before the machine on " + port().string() + " had answered"));
}

TEST_F(MachineSession, CheckSaysThatTheToolIsWhereNoSessionCanBegin) {
    VirtualToolOptions inside = axes();
    inside.start = kOrigin + Point(0, 0, 6);
    PortMachine machine(port(), {}, inside);
    EXPECT_EQ(run({"check", "part.yaml"}), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("the tool is inside the workspace"));
    EXPECT_EQ(run(probe("s")), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("the tool is inside the workspace")) << "the same verdict";
    EXPECT_EQ(machine.audit().moves, 0U);
}

TEST_F(MachineSession, AVirtualMachineRefusesWhatItCannotBe) {
    const auto vm = [&](std::vector<std::string> words) {
        words.insert(words.begin(), {"vm", "part.yaml", "--set", "object.shape.sphere.radius=5"});
        EXPECT_EQ(run(words), 2);
        return read("out.txt");
    };
    EXPECT_THAT(vm({"--modbus", "0.0.0.0:5020"}), HasSubstr("allowed: 127.0.0.1:PORT"));
    EXPECT_THAT(vm({"--modbus", "127.0.0.1:0", "--bounce", "0.5"}), HasSubstr("of the virtual GRBL controller"));
    EXPECT_THAT(vm({"--grbl", "link", "--spurious", "nan"}), HasSubstr("from 0 to 1"));
    EXPECT_THAT(vm({"--grbl", "link", "--audit", "missing/audit.json"}), HasSubstr("missing/audit.json"));
    const HiddenObject object(ShapeSpec{SphereSpec{kRadius}});
    VirtualModbusOptions options;
    options.tool = axes();
    VirtualModbus first(object, options, VirtualModbusTcp{});
    const std::string port = std::to_string(std::get<ModbusTcp>(first.link().where).port);
    EXPECT_THAT(vm({"--modbus", "127.0.0.1:" + port}), HasSubstr("give another port"));
}

TEST_F(MachineSession, AFullDiskEndsResumable) {
    ASSERT_NO_FATAL_FAILURE(run_reference());
    PortMachine machine(port());
    ASSERT_EQ(start(probe("full"), 20'000).wait(), 3) << read("out.txt");
    EXPECT_THAT(read("out.txt"), HasSubstr("journal.jsonl: cannot be written"));
    ASSERT_EQ(run(resume("full")), 0) << read("out.txt");
    expect_same("full");
    expect_safe(machine);
}

TEST_F(MachineSession, ADiskThatIsFullAtTheLastFilesCostsNothing) {
    if (!fs::exists("/dev/full")) GTEST_SKIP();
    ASSERT_NO_FATAL_FAILURE(run_reference());
    fs::create_directories(folder_ / "late");
    fs::create_symlink("/dev/full", folder_ / "late/summary.json.unfinished");
    {
        PortMachine machine(port());
        EXPECT_EQ(run(probe("late")), 2);
        expect_safe(machine);
    }
    EXPECT_THAT(read("out.txt"), HasSubstr("late/summary.json: cannot be written: No space left on device. Nothing is lost"));
    EXPECT_THAT(read("out.txt"), HasSubstr("palpate resume late\n"));
    EXPECT_FALSE(fs::exists(folder_ / "late/summary.json"));
    // There is room again, and no machine.
    EXPECT_EQ(run({"resume", "late"}), 0) << read("out.txt");
    EXPECT_TRUE(fs::exists(folder_ / "late/summary.json"));
    expect_same("late");
}

TEST_F(MachineSession, AFinishedSessionIsReplayedByteForByteWithoutAMachine) {
    ASSERT_NO_FATAL_FAILURE(run_reference());
    const std::vector<std::string> files = {"mesh.ply", "summary.json", "touches.csv", "picture.png"};
    std::vector<std::string> before;
    for (const std::string& file : files) {
        before.push_back(read("reference/" + file));
        fs::remove(folder_ / "reference" / file);
    }
    ASSERT_EQ(run({"resume", "--replay", "reference"}), 0) << read("out.txt");
    for (std::size_t k = 0; k < files.size(); ++k) EXPECT_EQ(read("reference/" + files[k]), before[k]) << files[k];
    fs::remove(folder_ / "reference/mesh.ply");
    EXPECT_EQ(run(resume("reference")), 0) << "it is finished, but perhaps killed before all was written";
    EXPECT_EQ(read("reference/mesh.ply"), before[0]);
    // Another configuration does not fit the journal.
    std::ofstream(folder_ / "reference/config.yaml", std::ios::app) << "# changed\n";
    EXPECT_EQ(run({"resume", "--replay", "reference"}), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("config.yaml: was changed"));
}

TEST_F(MachineSession, JournalAndResultsTellProgramConfigurationAndObject) {
    fs::copy_file(std::string(PALPATE_TEST_DATA) + "/cases/asc_name_facet.stl", folder_ / "part.stl");
    const std::string hash = file_sha256(folder_ / "part.stl");
    ASSERT_EQ(hash.size(), 64U);
    PortMachine machine(port());
    auto words = probe("named");
    words.insert(words.end(), {"--set", "object.mesh=part.stl"});
    ASSERT_EQ(run(words), 0) << read("out.txt");
    EXPECT_THAT(read("named/config.yaml"), HasSubstr("mesh: \"../part.stl\""));
    // The file may change meanwhile: results tell what it was when the session began.
    std::ofstream(folder_ / "part.stl", std::ios::app) << "\n";
    const std::string mesh = read("named/mesh.ply");
    ASSERT_EQ(run({"resume", "--replay", "named"}), 0) << read("out.txt");
    EXPECT_EQ(read("named/mesh.ply"), mesh);
    const JournalHeader header = read_journal(folder_ / "named/journal.jsonl").header;
    const auto summary = nlohmann::json::parse(read("named/summary.json"));
    EXPECT_EQ(header.version, summary.at("program").at("version"));
    EXPECT_EQ(header.config, summary.at("configuration").at("digest"));
    EXPECT_EQ(header.object_sha256, hash);
    EXPECT_EQ(summary.at("object").at("sha256"), hash);
    EXPECT_EQ(summary.at("object").at("mesh"), "../part.stl");
    EXPECT_THAT(mesh, HasSubstr("\ncomment configuration: CRC-32 " + header.config + "\ncomment object: SHA-256 " + hash + "\n"));
}

TEST_F(MachineSession, ASecondProcessIsRefusedOnThePortAndOnTheSession) {
    PortMachine machine(port());
    Process first = start(probe("mine"));
    wait_for_probes(machine, 20);
    EXPECT_EQ(run(probe("other")), 3);
    EXPECT_THAT(read("out.txt"), HasSubstr("in use by another process"));
    EXPECT_FALSE(fs::exists(folder_ / "other/config.yaml")) << "a session that never began is not in the way";
    EXPECT_EQ(run(resume("mine")), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("another process works in it"));
    EXPECT_EQ(first.wait(), 0);
    expect_safe(machine);
}

// On the ways back, and on the known place that it has just touched again.
TEST_F(MachineSession, CutOffWhileItReturnsItIsResumedAgain) {
    ASSERT_NO_FATAL_FAILURE(run_reference());
    {
        PortMachine machine(port());
        Process process = start(probe("returning"));
        wait_for_probes(machine, 60);
        process.send(SIGKILL);
        (void)process.wait();
    }
    const Point rest = read_journal(folder_ / "returning/journal.jsonl").last_rest();
    for (int move = 1; move <= 8; ++move) {
        SCOPED_TRACE(move);
        const std::string name = "returning_" + std::to_string(move);
        fs::copy(folder_ / "returning", folder_ / name, fs::copy_options::recursive);
        VirtualToolOptions there = axes();
        there.start = kOrigin + rest;
        VirtualGrblOptions options;
        options.faults = {{VirtualFault::Kind::hang_up, VirtualFault::When::probe, static_cast<double>(move)}};
        PortMachine machine(port(), options, there);
        EXPECT_EQ(run(resume(name)), 3) << read("out.txt");
        machine.host().plug_in();
        EXPECT_EQ(run(resume(name)), 0) << read("out.txt");
        expect_same(name);
        expect_safe(machine);
    }
}

TEST_F(MachineSession, APartThatMovedMeanwhileIsNoticedBeforeAnythingElse) {
    {
        PortMachine machine(port());
        Process process = start(probe("moved"));
        wait_for_probes(machine, 100);
        process.send(SIGKILL);
        (void)process.wait();
    }
    const std::size_t before = read_journal(folder_ / "moved/journal.jsonl").moves.size();
    VirtualToolOptions elsewhere = axes();
    elsewhere.origin += Vector(0.25, 0.25, 0.25);
    PortMachine machine(port(), {}, elsewhere);
    EXPECT_EQ(run(resume("moved")), 3);
    EXPECT_THAT(read("out.txt"), ::testing::AnyOf(HasSubstr("has moved"), HasSubstr("where space should be free")));
    EXPECT_EQ(read_journal(folder_ / "moved/journal.jsonl").moves.size(), before) << "nothing false was recorded";
    expect_safe(machine);
}

TEST_F(MachineSession, FalseTriggersAndBouncesLeaveTheTopologyAsItIs) {
    int false_triggers = 0;
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
        VirtualGrblOptions options;
        options.spurious_rate = 0.02;
        options.bounce_rate = 0.02;
        options.seed = seed;
        PortMachine machine(port(), options);
        const std::string name = "noisy_" + std::to_string(seed);
        ASSERT_EQ(run(probe(name)), 0) << read("out.txt");
        const auto summary = nlohmann::json::parse(read(fs::path(name) / "summary.json"));
        EXPECT_EQ(summary.at("euler_characteristic"), 2);
        EXPECT_EQ(summary.at("boundary_edges"), 0);
        EXPECT_EQ(summary.at("nonmanifold_edges"), 0);
        false_triggers += summary.at("machine").at("events").at("spurious_trigger").get<int>();
        expect_safe(machine);
    }
    // Some 150 moves each.
    EXPECT_GT(false_triggers, 0);
}

// Moves that meet nothing may end where the probe is pressed less than its pre-travel; a way back there has to find it open again.
TEST_F(MachineSession, PreTravelAndPlayOfTheAxesEndNoSession) {
    std::ofstream(folder_ / "torus.yaml") << "object: {shape: {torus: {major: 20, minor: 8}}}\n"
                                             "machine:\n  grbl: {port: "
                                          << port().string()
                                          << "}\n  homing: run\n  origin: [-150, -100, -60]\n"
                                             "  limits: {min: [-40, -40, -15], max: [40, 40, 40]}\n"
                                             "  noise: 0.12\n  touch: {tolerance: 0.05}\n"
                                             "workspace: {box: {min: [-31, -31, -11], max: [31, 31, 11]}}\n"
                                             "probing: {epsilon: 4, strategy: adaptive}\n"
                                             "simulation: {errors: {lobes: 0.04, backlash: [0.01, 0.01, 0.01]}}\n";
    fs::create_directory(folder_ / "vm");
    Process vm(folder_ / "vm", {"vm", "../torus.yaml", "--grbl", port().string(), "--fast", "--locked", "--audit", "audit"});
    for (int k = 0; k < 500 && !fs::exists(port()); ++k) std::this_thread::sleep_for(20ms);
    EXPECT_EQ(run({"probe", "torus.yaml", "-o", "torus", "--yes"}), 0) << read("out.txt");
    vm.send(SIGINT);
    EXPECT_EQ(vm.wait(), 0);
    const auto audit = nlohmann::json::parse(read("vm/audit"));
    for (const char* count : {"unguarded_moves", "outside_limits", "unsafe_moves", "fast_moves_inside"})
        EXPECT_EQ(audit.at(count), 0) << count;
    const auto summary = nlohmann::json::parse(read("torus/summary.json"));
    EXPECT_EQ(summary.at("euler_characteristic"), 0);
    EXPECT_EQ(summary.at("boundary_edges"), 0);
}

// devices/README.md, "A real GRBL machine, step by step", on a copy of the template that it begins with, in another folder.
TEST_F(MachineSession, TheTextOfTheFirstSessionRunsOnItsTemplate) {
    fs::copy_file(PALPATE_SOURCE_DIR "/config/machines/grbl.yaml", folder_ / "part.yaml", fs::copy_options::overwrite_existing);
    fs::create_directory(folder_ / "vm");
    Process vm(folder_ / "vm", {"vm", "../part.yaml", "--grbl", port().string(), "--fast", "--audit", "audit"});
    for (int k = 0; k < 500 && !fs::exists(port()); ++k) std::this_thread::sleep_for(20ms);
    std::ifstream text(PALPATE_SOURCE_DIR "/devices/README.md");
    std::string line;
    while (std::getline(text, line) && line != "## A real GRBL machine, step by step") {
    }
    std::vector<std::string> seen;
    while (std::getline(text, line) && !line.starts_with("## ")) {
        for (const char* name : {"palpate check part.yaml", "palpate touch part.yaml", "palpate probe part.yaml"}) {
            const std::size_t begin = line.find(name);
            if (begin == std::string::npos) continue;
            std::istringstream words(line.substr(begin, line.find('`', begin) - begin));
            std::vector<std::string> command;
            for (std::string word; words >> word;) command.push_back(word);
            command.erase(command.begin());
            seen.push_back(command.front());
            for (const std::string& word : {std::string("--set"), "machine.grbl.port=" + port().string()}) command.push_back(word);
            if (command.front() != "check") command.emplace_back("--yes");
            EXPECT_EQ(run(command), 0) << line << '\n' << read("out.txt");
            if (command.front() == "touch") {
                EXPECT_THAT(read("out.txt"), HasSubstr("contact at (3, 0, "));
            }
        }
    }
    EXPECT_EQ(seen, (std::vector<std::string>{"check", "touch", "probe"}));
    EXPECT_EQ(nlohmann::json::parse(read("part/summary.json")).at("euler_characteristic"), 0) << "a ring";
    vm.send(SIGINT);
    EXPECT_EQ(vm.wait(), 0);
}

TEST_F(MachineSession, NothingMovesWithoutConsent) {
    PortMachine machine(port());
    EXPECT_EQ(run({"probe", "part.yaml", "-o", "unasked"}), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("--yes"));
    EXPECT_EQ(run({"touch", "part.yaml", "--from", "0,0,12", "--to", "0,0,0"}), 2);
    EXPECT_EQ(run({"check", "part.yaml"}), 0) << read("out.txt");
    EXPECT_THAT(read("out.txt"), HasSubstr("nothing has moved"));
    EXPECT_EQ(machine.audit().moves, 0U);
    EXPECT_EQ(run({"touch", "part.yaml", "--from", "0,0,12", "--to", "0,0,0", "--yes"}), 0) << read("out.txt");
    EXPECT_THAT(read("out.txt"), HasSubstr("contact at (0, 0, 5) mm, 7 mm from"));
    expect_safe(machine);
}

TEST_F(MachineSession, NothingMovesOutsideTheLimitsNotEvenBack) {
    PortMachine machine(port());
    const std::vector<std::string> narrow = {"--set", "machine.limits.max=[15, 15, 13]"};  // the tool waits at 14
    auto words = probe("outside");
    words.insert(words.end(), narrow.begin(), narrow.end());
    EXPECT_EQ(run(words), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("outside machine.limits"));
    EXPECT_FALSE(fs::exists(folder_ / "outside/journal.jsonl"));
    EXPECT_EQ(run({"touch", "part.yaml", "--from", "0,0,12", "--to", "0,0,16", "--yes"}), 2) << "nothing moves for a way that is not whole";
    EXPECT_EQ(machine.audit().moves, 0U);
    // A session that was interrupted, and a tool that somebody has moved out of the limits since.
    Process process = start(probe("away"));
    wait_for_probes(machine, 60);
    process.send(SIGKILL);
    (void)process.wait();
    machine.host().with([](VirtualGrbl&) {});
    const std::uint64_t moves = machine.audit().moves;
    while (!machine.place_by_hand(kOrigin + Point(0, 0, 15.5))) std::this_thread::sleep_for(1ms);
    EXPECT_EQ(run(resume("away")), 3);
    EXPECT_THAT(read("out.txt"), HasSubstr("outside machine.limits"));
    EXPECT_LE(machine.audit().moves, moves + 1) << "what was under way ended, and nothing moved after that";
}

TEST_F(MachineSession, AFinishedSessionLeavesTheToolOutsideForTheNext) {
    PortMachine machine(port());
    ASSERT_EQ(run(probe("first")), 0) << read("out.txt");
    EXPECT_EQ(run(probe("second")), 0) << read("out.txt");
    EXPECT_EQ(read("first/mesh.ply"), read("second/mesh.ply"));
    expect_safe(machine);
}

TEST_F(MachineSession, AFolderInWhichNoSessionEverBeganIsFree) {
    fs::create_directories(folder_ / "left");
    std::ofstream(folder_ / "left/config.yaml") << "left by a process that was killed\n";
    std::ofstream(folder_ / "left/journal.jsonl").flush();
    PortMachine machine(port());
    EXPECT_EQ(run(probe("left")), 0) << read("out.txt");
    EXPECT_EQ(run(probe("left")), 2) << "now there is one";
}

TEST_F(MachineSession, ASessionThatCannotBeginSaysWhyAndLeavesNothing) {
    EXPECT_EQ(run(probe("no_port")), 3);
    EXPECT_THAT(read("out.txt"), HasSubstr("palpate ports"));
    EXPECT_FALSE(fs::exists(folder_ / "no_port/config.yaml"));
    EXPECT_EQ(run({"probe", "part.yaml", "-o", "x", "--yes", "--set", "machine.feeds.travel=90"}), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("overtravel"));
    EXPECT_EQ(run({"probe", "part.yaml", "-o", "x", "--yes", "--set", "probing.epsilon=0.01"}), 2);
    EXPECT_EQ(run({"probe", "part.yaml", "-o", "x", "--yes", "--set", "workspace=auto"}), 2);
    EXPECT_EQ(run({"probe", "part.yaml", "-o", "x", "--yes", "--set", "workspace={ball: {center: [0, 0, 0], radius: 15}}"}), 2);
    EXPECT_THAT(read("out.txt"), HasSubstr("machine.limits"));
    EXPECT_EQ(run({"resume", "x"}), 2);
}

}  // namespace
}  // namespace palpate::machine_session_test
