// Sessions as a user runs them, on virtual machines that drift by 50 µm while they last, with a block beside the sphere as datum.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <nlohmann/json.hpp>
#include <sstream>

#include "devices/session/drift_log.h"
#include "sim/machines/modbus/virtual_modbus.h"
#include "sim/objects/mesh/mesh_file.h"
#include "tests/random.h"
#include "tests/tools/session_rig.h"

namespace palpate::drift_test {
namespace {

using ::testing::HasSubstr;

const std::string kDatum =
    "\n  noise: 0.01\n  datum:\n    every: 8\n    at:\n      - {from: [9, 0, 0], to: [11, 0, 0]}\n"
    "      - {from: [11.5, -3, 0], to: [11.5, -0.5, 0]}\n      - {from: [11.5, 0, 3], to: [11.5, 0, 0.5]}\n    limit: 0.05";

ShapeSpec sphere_and_block() {
    return {std::vector<ShapeSpec>{{SphereSpec{kRadius}}, {RoundedBoxSpec{Vector::Constant(2), 0}, Point(11.5, 0, 0)}}};
}

class Drift : public SessionRig {
protected:
    Drift() { write("part.yaml", grbl() + kDatum); }

    [[nodiscard]] std::string grbl() const { return "grbl: {port: " + port().string() + "}\n  homing: run"; }
    [[nodiscard]] static VirtualToolOptions drifting(const Vector& per_1000_touches, const Point& start = kAbove) {
        VirtualToolOptions options = axes();
        options.errors.drift_mm_per_1000_touches = per_1000_touches;
        options.start = start;
        return options;
    }
    // Of touches of the sphere and looks at them again, with those of the datum between.
    [[nodiscard]] static Vector fifty_micrometres(std::uint64_t touches) {
        return 0.050 * 1000 / static_cast<double>(touches) * Vector(2, -1, 2).normalized();
    }
    [[nodiscard]] TriangleMesh mesh_of(const std::string& session) const { return read_triangles(folder_ / session / "mesh.ply"); }
    [[nodiscard]] double worst_vertex(const std::string& session) const {
        double worst = 0;
        for (const Point& p : mesh_of(session).points) worst = std::max(worst, std::abs(p.norm() - kRadius));
        return worst;
    }
    // mm: the same, wherever the sphere's centre is, and where that is.
    [[nodiscard]] std::pair<double, Point> worst_around_center(const std::string& session) const {
        const std::vector<Point> points = mesh_of(session).points;
        Point center = Point::Zero();
        for (int k = 0; k < 20; ++k) {
            Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
            Vector right = Vector::Zero();
            for (const Point& p : points) {
                const Vector out = (p - center).normalized();
                normal += out * out.transpose();
                right += ((p - center).norm() - kRadius) * out;
            }
            center += normal.ldlt().solve(right);
        }
        double worst = 0;
        for (const Point& p : points) worst = std::max(worst, std::abs((p - center).norm() - kRadius));
        return {worst, center};
    }
    [[nodiscard]] nlohmann::json summary(const std::string& session) const {
        return nlohmann::json::parse(read(session + "/summary.json"));
    }
    void expect_same_again(const std::string& session) const {
        const std::string mesh = read(session + "/mesh.ply");
        const std::string touches = read(session + "/touches.csv");
        const std::string account = read(session + "/summary.json");
        ASSERT_EQ(run({"resume", "--replay", session}), 0) << read("out.txt");
        EXPECT_EQ(read(session + "/mesh.ply"), mesh);
        EXPECT_EQ(read(session + "/touches.csv"), touches);
        EXPECT_EQ(read(session + "/summary.json"), account);
    }
};

TEST_F(Drift, OfFiftyMicrometresLeavesFiveOfThemOnAGrblMachineWithADatum) {
    Vector drift;
    {
        PortMachine machine(port(), {}, axes(), sphere_and_block());
        ASSERT_EQ(run(probe("still")), 0) << read("out.txt");
        const auto still = summary("still");
        EXPECT_EQ(still.at("machine").at("drift").at("largest_shift"), 0);
        drift = fifty_micrometres(2 * still.at("probes").at("contact").get<std::uint64_t>());
    }
    {
        PortMachine machine(port(), {}, drifting(drift), sphere_and_block());
        ASSERT_EQ(run(probe("with")), 0) << read("out.txt");
        expect_safe(machine);
    }
    EXPECT_THAT(read("out.txt"), HasSubstr("drift          "));
    EXPECT_THAT(read("out.txt"), HasSubstr(" visits to the datum, "));
    EXPECT_LE(worst_vertex("with"), 0.005);
    const auto found = summary("with").at("machine").at("drift");
    EXPECT_EQ(found.at("directions"), 3);
    EXPECT_EQ(found.at("touches").get<int>(), 3 * found.at("visits").get<int>());
    EXPECT_GE(found.at("largest_shift").get<double>(), 0.050);
    EXPECT_EQ(summary("with").at("euler_characteristic"), 2);
    expect_same_again("with");

    write("part.yaml", grbl() + "\n  noise: 0.01");
    {
        PortMachine machine(port(), {}, drifting(drift), sphere_and_block());
        // That a bound on the reach seems to be false is the drift's doing, too.
        EXPECT_THAT(run(probe("without")), ::testing::AnyOf(0, 5)) << read("out.txt");
    }
    EXPECT_GE(worst_vertex("without"), 0.030);
    EXPECT_FALSE(summary("without").at("machine").contains("drift"));
    std::printf(
        "worst vertex %.1f um with the datum, %.1f um without; %d visits, largest shift %.1f um, largest change %.1f um, way %.0f mm\n",
        1e3 * worst_vertex("with"), 1e3 * worst_vertex("without"), found.at("visits").get<int>(),
        1e3 * found.at("largest_shift").get<double>(), 1e3 * found.at("largest_change").get<double>(), found.at("way").get<double>());
}

TEST_F(Drift, OnAModbusMachineToo) {
    const HiddenObject object(sphere_and_block());
    VirtualModbusOptions options;
    options.tool = drifting(fifty_micrometres(150));
    options.speedup = 500;
    VirtualModbus modbus(object, options, VirtualModbusTcp{});
    const int tcp = std::get<ModbusTcp>(modbus.link().where).port;
    write("modbus.yaml", "modbus: {tcp: {host: 127.0.0.1, port: " + std::to_string(tcp) + "}}" + kDatum);
    ASSERT_EQ(run({"probe", "modbus.yaml", "-o", "tcp", "--yes", "--set", "probing.epsilon=3"}), 0) << read("out.txt");
    EXPECT_LE(worst_vertex("tcp"), 0.005);
    EXPECT_GE(summary("tcp").at("machine").at("drift").at("largest_shift").get<double>(), 0.02);
    const VirtualToolAudit audit = modbus.with_controller([](const VirtualModbusController& c) { return c.tool().audit(); });
    EXPECT_EQ(audit.unguarded_moves + audit.outside_limits + audit.unsafe_moves, 0U);
    expect_same_again("tcp");
}

TEST_F(Drift, KilledAnywhereAndResumedASessionEndsWithTheSameBytes) {
    constexpr std::uint64_t kSeed = 19;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    double whole = 0;
    {
        PortMachine machine(port(), {}, axes(), sphere_and_block());
        const auto begin = std::chrono::steady_clock::now();
        ASSERT_EQ(run(probe("reference")), 0) << read("out.txt");
        whole = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    }
    for (const bool drifts : {false, true}) {
        for (int trial = 0; trial < 5; ++trial) {
            const std::string name = (drifts ? "drifting_" : "still_") + std::to_string(trial);
            SCOPED_TRACE(name);
            PortMachine machine(port(), {}, drifting(drifts ? fifty_micrometres(200) : Vector::Zero()), sphere_and_block());
            int code = 0;
            for (int kills = 0;; ++kills) {
                const fs::path journal = folder_ / name / "journal.jsonl";
                if (!fs::exists(journal) || fs::file_size(journal) == 0) fs::remove_all(folder_ / name);
                Process process = start(fs::exists(journal) ? resume(name) : probe(name));
                if (kills < 3) {
                    std::this_thread::sleep_for(std::chrono::duration<double>(random.uniform(0.1, 0.6) * whole));
                    process.send(SIGKILL);
                }
                code = process.wait();
                if (code != 128 + SIGKILL) break;
            }
            ASSERT_EQ(code, 0) << read("out.txt");
            expect_safe(machine);
            expect_same_again(name);
            if (drifts) {
                EXPECT_LE(worst_vertex(name), 0.005);
            } else {
                EXPECT_EQ(read(name + "/touches.csv"), read("reference/touches.csv"));
                const auto mesh = mesh_of(name);
                EXPECT_EQ(mesh.points, mesh_of("reference").points);
                EXPECT_EQ(mesh.triangles, mesh_of("reference").triangles);
            }
        }
    }
}

TEST_F(Drift, BeyondTheLimitStopsTheSessionWhichGoesOnOnceThatIsMended) {
    {
        PortMachine machine(port(), {}, drifting(Vector(0, 0, 6)), sphere_and_block());
        ASSERT_EQ(run(probe("jumped")), 3) << read("out.txt");
        expect_safe(machine);
        EXPECT_THAT(read("out.txt"), HasSubstr("more than machine.datum.limit, 0.05 mm"));
        EXPECT_THAT(read("out.txt"), HasSubstr("palpate resume jumped"));
        ASSERT_EQ(run(resume("jumped")), 3) << "it still drifts like that";
    }
    const Point rest = read_journal(folder_ / "jumped/journal.jsonl").last_rest();
    PortMachine machine(port(), {}, drifting(Vector::Zero(), kOrigin + rest), sphere_and_block());
    ASSERT_EQ(run(resume("jumped")), 0) << read("out.txt");
    expect_safe(machine);
    // The frame is that of the first visit, in which it drifted already.
    const auto [worst, center] = worst_around_center("jumped");
    EXPECT_LE(worst, 0.005) << "what was touched since the first visit was touched again";
    EXPECT_GT(center.norm(), 0.010);
    expect_same_again("jumped");
}

TEST_F(Drift, APartAndDatumThatMovedMeanwhileAreNoticedBeforeAnythingElse) {
    const auto machine_at = [&](const Vector& shift) {
        VirtualToolOptions options = axes();
        if (fs::exists(folder_ / "moved/journal.jsonl"))
            options.start = kOrigin + read_journal(folder_ / "moved/journal.jsonl").last_rest();
        options.origin += shift;
        return std::make_unique<PortMachine>(port(), VirtualGrblOptions{}, options, sphere_and_block());
    };
    {
        const auto machine = machine_at(Vector::Zero());
        Process process = start(probe("moved"));
        wait_for_probes(*machine, 120);
        process.send(SIGINT);
        ASSERT_EQ(process.wait(), 3) << read("out.txt");
    }
    const std::string journal = read("moved/journal.jsonl");
    {
        const auto machine = machine_at(Vector(0, 0.2, 0));
        ASSERT_EQ(run(resume("moved")), 3) << read("out.txt");
        EXPECT_THAT(read("out.txt"), HasSubstr("the datum is 0.2000 mm from where the visit before found it"));
        EXPECT_EQ(read("moved/journal.jsonl"), journal);
    }
    // All that shifted by less is what another homing does.
    const auto machine = machine_at(Vector(0, 0.03, 0));
    ASSERT_EQ(run(resume("moved")), 0) << read("out.txt");
    expect_safe(*machine);
    EXPECT_NEAR(summary("moved").at("machine").at("drift").at("shift")[1].get<double>(), 0.03, 0.0011);
    EXPECT_LE(worst_vertex("moved"), 0.03);
    expect_same_again("moved");
}

TEST_F(Drift, ADatumThatCannotBeTouchedIsRefusedWithItsKey) {
    PortMachine machine(port(), {}, axes(), sphere_and_block());
    const auto complaint = [&](const std::string& at) {
        write("part.yaml", grbl() + "\n  datum: {at: " + at + "}");
        EXPECT_EQ(run(probe("refused")), 2) << read("out.txt");
        EXPECT_FALSE(fs::exists(folder_ / "refused"));
        return read("out.txt");
    };
    EXPECT_THAT(complaint("[]"), HasSubstr("part.yaml:4: machine.datum.at: "));
    EXPECT_THAT(complaint("[{from: [9, 0, 0]}]"), HasSubstr("machine.datum.at[0].to: is required"));
    EXPECT_THAT(complaint("[{from: [9, 0, 0], to: [9, 0, 0]}]"), HasSubstr("machine.datum.at[0].to: is where `from` is"));
    EXPECT_THAT(complaint("[{from: [6, 0, 0], to: [11, 0, 0]}]"), HasSubstr("machine.datum.at[0]: from (6, 0, 0) mm to (11, 0, 0) mm it "
                                                                            "leads through the workspace"));
    EXPECT_EQ(machine.probes(), 0U);
}

}  // namespace
}  // namespace palpate::drift_test
