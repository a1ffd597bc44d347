// Whole sessions with a ball on a stylus, a block on a table and a clamp that holds it: killed and taken up again, and on another
// controller.
#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "config/reader.h"
#include "devices/session/journal.h"
#include "planner/number_text.h"
#include "sim/tool/tool_audit.h"
#include "sim/tool/tool_obstacle.h"
#include "tests/random.h"
#include "tests/tools/session_rig.h"
#include "tools/simulation.h"

namespace palpate::table_session_test {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;
using Part = ToolContact::Part;
using Met = ToolContact::Met;

// A machine that hides what the configuration names, before the tool that it names.
class TableMachine {
public:
    TableMachine(const fs::path& link, const SessionConfig& config)
        : object_(*config.object),
          scene_(*tool_scene(config, object_)),
          body_(scene_.depths, config.machine->motion.overtravel_mm + config.machine->motion.resolution_mm + ToolAudit::kTolerance_mm),
          tool_(scene_.obstacle, axes(*config.machine)),
          grbl_(tool_, homed()),
          host_(grbl_, {link, GrblHostOptions::Time::fast, false}) {}

    [[nodiscard]] std::uint64_t probes() {
        std::uint64_t probes = 0;
        host_.with([&](VirtualGrbl& grbl) { probes = grbl.counts().probes; });
        return probes;
    }
    void expect_safe() {
        host_.with([&](VirtualGrbl&) {
            const VirtualToolAudit& seen = tool_.audit();
            EXPECT_GT(seen.moves, 0U);
            EXPECT_EQ(seen.unguarded_moves, 0U);
            EXPECT_EQ(seen.outside_limits, 0U);
            EXPECT_EQ(seen.unsafe_moves, 0U);
            EXPECT_EQ(seen.fast_moves_inside, 0U);
            const ToolAccount& account = body_.account();
            EXPECT_GE(account.moves, seen.moves);
            EXPECT_EQ(account.unsafe_moves, 0U);
            EXPECT_EQ(account.moves_into_fixtures, 0U);
            for (const Part part : {Part::ball, Part::stylus, Part::holder}) EXPECT_EQ(account.touches(part, Met::fixture), 0U);
        });
    }

private:
    VirtualToolOptions axes(const MachineConfig& machine) {
        VirtualToolOptions options;
        options.motion = machine.motion;
        options.origin = machine.origin;
        options.start = machine.origin + Point(0, 0, machine.limits.max.z());
        options.limits = {machine.origin + machine.limits.min, machine.origin + machine.limits.max};
        options.probe_feed_mm_per_s = machine.motion.feeds.probe_mm_per_s;
        options.on_move = [this](const Segment& way, bool touched) { body_.record(way, touched); };
        return options;
    }
    [[nodiscard]] VirtualGrblOptions homed() const {
        VirtualGrblOptions options;
        options.homed_position = tool_.options().start;
        options.soft_limits = true;
        return options;
    }

    HiddenObject object_;
    ToolScene scene_;
    ToolAudit body_;
    VirtualTool tool_;
    VirtualGrbl grbl_;
    GrblHost host_;
};

class TableSession : public SessionRig {
protected:
    TableSession() { write_part("grbl: {port: " + port().string() + "}\n  homing: run"); }

    void write_part(const std::string& connection) const {
        std::ofstream(folder_ / "part.yaml") << "machine:\n  " << connection << "\n"
                                             << "  origin: [-60, -50, -60]\n"
                                                "  limits: {min: [-20, -18, 0.5], max: [20, 18, 30]}\n"
                                                "  retract: 0.2\n"
                                                "tool: {ball: {diameter: 2}, stylus: {diameter: 1.4, length: 40}}\n"
                                                "workspace:\n"
                                                "  box: {min: [-16, -15, 0], max: [16, 15, 16]}\n"
                                                "  fixtures:\n"
                                                "    - table: {z: 0}\n"
                                                "    - box: {min: [-9, -3, 0], max: [-4, 3, 8]}\n"
                                                "probing: {epsilon: 1.2}\n"
                                                "object: {shape: {rounded_box: {size: [12, 10, 6], fillet: 0}, at: [0, 0, 3]}}\n";
    }
    [[nodiscard]] SessionConfig config() const { return read_config(folder_ / "part.yaml"); }
    [[nodiscard]] Json summary(const std::string& session) const { return Json::parse(read(session + "/summary.json")); }
};

TEST_F(TableSession, KilledAtTwentyMomentsItEndsWithTheSameBytes) {
    constexpr std::uint64_t kSeed = 2028;
    constexpr int kKills = 20;
    constexpr int kKillsOfOne = 5;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    std::uint64_t probes = 0;
    {
        TableMachine machine(port(), config());
        ASSERT_EQ(run(probe("reference")), 0) << read("out.txt");
        machine.expect_safe();
        probes = machine.probes();
        ASSERT_GT(probes, 200U);
    }
    int kills = 0;
    for (int session = 0; kills < kKills; ++session) {
        const std::string name = "killed_" + std::to_string(session);
        SCOPED_TRACE(name);
        TableMachine machine(port(), config());
        std::uint64_t resumed = 0;
        for (int kill = 0;; ++kill) {
            const bool has_begun = fs::exists(folder_ / name / "journal.jsonl") && fs::file_size(folder_ / name / "journal.jsonl") > 0;
            Process process = start(has_begun ? resume(name) : probe(name));
            if (kill < kKillsOfOne && kills < kKills) {
                // By what the machine has done, so that moments are spread over the session on any computer.
                const std::uint64_t until = machine.probes() + random.below(probes / 4);
                for (int k = 0; k < 20'000 && machine.probes() < until; ++k) std::this_thread::sleep_for(1ms);
                std::this_thread::sleep_for(random.uniform(0, 5) * 1ms);
                process.send(SIGKILL);
            }
            const int code = process.wait();
            if (code == 0) break;
            ASSERT_EQ(code, 128 + SIGKILL) << read("out.txt");
            ++kills;
            resumed += has_begun ? 1 : 0;
        }
        for (const char* file : {"mesh.ply", "mesh_tool.ply", "touches.csv"}) {
            EXPECT_TRUE(read(name + "/" + file) == read(std::string("reference/") + file)) << file;
        }
        EXPECT_LE(read_journal(folder_ / name / "journal.jsonl").resumptions.size(), resumed + 1);
        machine.expect_safe();
        ASSERT_FALSE(HasFailure());
    }
}

// Of what a run has touched: where the ball's centre was, and where it says that the part is.
struct Told {
    Point center;
    std::string tag;
    Point part;
    double uncertainty;  // mm
};

std::vector<Told> told_by(const std::string& touches) {
    std::vector<Told> all;
    std::istringstream in(touches);
    std::string line;
    std::getline(in, line);
    while (std::getline(in, line)) {
        std::vector<std::string> words;
        std::istringstream fields(line);
        for (std::string word; std::getline(fields, word, ',');) words.push_back(word);
        words.resize(14);
        const auto number = [&](std::size_t k) { return words[k].empty() ? std::nan("") : std::stod(words[k]); };
        all.push_back({{number(1), number(2), number(3)}, words[9], {number(10), number(11), number(12)}, number(13)});
    }
    return all;
}

TEST_F(TableSession, OnAModbusControllerItFindsWhatASimulationFinds) {
    write_part("modbus: {tcp: {host: 127.0.0.1, port: 502}}");
    fs::create_directory(folder_ / "vm");
    Process vm(folder_ / "vm", {"vm", "../part.yaml", "--modbus", "127.0.0.1:0", "--fast", "--audit", "audit.json"});
    const std::string before = "on 127.0.0.1:";
    std::string said;
    for (int k = 0; k < 1000 && said.find(';') == std::string::npos; ++k) {
        std::this_thread::sleep_for(20ms);
        said = read("vm/out.txt");
    }
    ASSERT_NE(said.find(before), std::string::npos) << said;
    const int tcp_port = std::stoi(said.substr(said.find(before) + before.size()));
    auto words = probe("probed");
    words.insert(words.end(), {"--set", "machine.modbus.tcp.port=" + std::to_string(tcp_port)});
    EXPECT_EQ(run(words), 0) << read("out.txt");
    vm.send(SIGINT);
    EXPECT_EQ(vm.wait(), 0) << read("vm/out.txt");
    ASSERT_EQ(run({"simulate", "part.yaml", "-o", "simulated"}), 0) << read("out.txt");
    ASSERT_FALSE(HasFailure());

    const Json audit = Json::parse(read("vm/audit.json"));
    EXPECT_GT(audit.at("moves"), 200);
    for (const char* count : {"unguarded_moves", "outside_limits", "unsafe_moves", "fast_moves_inside"})
        EXPECT_EQ(audit.at(count), 0) << count;
    const Json& body = audit.at("tool");
    EXPECT_EQ(body.at("moves_into_object"), 0);
    EXPECT_EQ(body.at("moves_into_fixtures"), 0);
    for (const char* part : {"ball", "stylus", "holder"}) EXPECT_EQ(body.at("touches").at(part).at("fixture"), 0) << part;

    const SessionConfig block = config();
    const HiddenObject object(*block.object);
    const ToolScene scene = *tool_scene(block, object);
    const double touch_error = block.traits().touch_error;
    EXPECT_LT(touch_error, 0.01);
    std::map<std::string, Json> summaries;
    for (const std::string session : {"probed", "simulated"}) {
        SCOPED_TRACE(session);
        const Json& found = summaries[session] = summary(session);
        for (const Json& of : {found, found.at("part")}) {
            EXPECT_EQ(of.at("components"), 1);
            EXPECT_EQ(of.at("euler_characteristic"), 2);
            EXPECT_EQ(of.at("boundary_edges"), 0);
            EXPECT_EQ(of.at("nonmanifold_edges"), 0);
        }
        EXPECT_TRUE(found.at("complete"));
        // Every touch is one of the exact surface that the ball's centre traces, and the part is as near as is said.
        std::size_t tips = 0;
        std::size_t beyond = 0;
        for (const Told& touch : told_by(read(session + "/touches.csv"))) {
            if (touch.tag == "fixture") continue;
            const auto gap = scene.depths.gap(touch.center, 1.0);
            ASSERT_TRUE(gap);
            EXPECT_LE(std::abs(*gap), touch_error) << point_text(touch.center);
            if (touch.tag != "tip") continue;
            ++tips;
            beyond += object.distance(touch.part) > touch.uncertainty ? 1 : 0;
        }
        EXPECT_GT(tips, 50U);
        EXPECT_LE(static_cast<double>(beyond), 0.01 * static_cast<double>(tips));
    }
    const auto expect_near = [&](const char* what, double probed, double simulated) {
        // Rounding decides where samples come to lie.
        EXPECT_NEAR(probed, simulated, 0.15 * std::abs(simulated)) << what;
    };
    for (const char* count : {"samples", "facets"}) expect_near(count, summaries["probed"].at(count), summaries["simulated"].at(count));
    expect_near("area of tips", summaries["probed"].at("part").at("area").at("tip"),
                summaries["simulated"].at("part").at("area").at("tip"));
}

}  // namespace
}  // namespace palpate::table_session_test
