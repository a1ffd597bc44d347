// The program itself, as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "devices/session/journal.h"

namespace palpate::command_line_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class CommandLine : public ::testing::Test {
protected:
    CommandLine() {
        std::string name = (fs::temp_directory_path() / "palpate_test_XXXXXX").string();
        folder_ = mkdtemp(name.data());
    }
    ~CommandLine() override { fs::remove_all(folder_); }

    struct Outcome {
        int exit_code = -1;
        std::string out;
        std::string err;
    };
    Outcome palpate(const std::string& words) {
        const std::string command = "cd '" + folder_.string() + "' && '" PALPATE_EXECUTABLE "' " + words + " >out.txt 2>err.txt </dev/null";
        const int status = std::system(command.c_str());
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read("out.txt"), read("err.txt")};
    }
    std::string read(const std::string& file) const {
        std::ifstream in(folder_ / file, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    }
    void write(const std::string& file, const std::string& content) const { std::ofstream(folder_ / file) << content; }
    void write_torus(double epsilon = 0.2) const {
        write("torus.yaml",
              "object: {shape: {torus: {major: 1, minor: 0.4}}}\nworkspace: auto\nprobing: {epsilon: " + std::to_string(epsilon) + "}\n");
    }

    fs::path folder_;
};

TEST_F(CommandLine, HelpShowsExamplesAndExitCodes) {
    const Outcome help = palpate("--help");
    EXPECT_EQ(help.exit_code, 0);
    EXPECT_THAT(help.out, HasSubstr("palpate simulate config/examples/bunny.yaml"));
    EXPECT_THAT(help.out, HasSubstr("4 incomplete result"));
    EXPECT_THAT(help.out, HasSubstr("5 a premise that was given is refuted"));
    for (const std::string command : {"simulate", "check", "bench", "picture"}) {
        EXPECT_THAT(palpate(command + " --help").out, HasSubstr("Example: palpate " + command));
    }
}

TEST_F(CommandLine, BadUsageIsExitCode2) {
    for (const std::string words : {"", "nonsense", "simulate", "simulate x.yaml", "check", "check a b", "bench", "simulate a -o b --up w",
                                    "picture", "picture a --up w"}) {
        const Outcome outcome = palpate(words);
        EXPECT_EQ(outcome.exit_code, 2) << words;
        EXPECT_NE(outcome.err, "") << words;
    }
    write_torus();
    EXPECT_EQ(palpate("bench torus.yaml --strategy clever").exit_code, 2);
}

TEST_F(CommandLine, WhatIsMistypedIsNamedAndTheLikelyWordProposed) {
    write_torus();
    const auto expect = [&](const std::string& words, const std::string& said, const std::string& next) {
        const Outcome outcome = palpate(words);
        EXPECT_EQ(outcome.exit_code, 2) << words;
        EXPECT_EQ(outcome.out, "") << words;
        EXPECT_THAT(outcome.err, ::testing::StartsWith(said + "\n")) << words;
        EXPECT_THAT(outcome.err, HasSubstr(next)) << words;
        EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 2) << words << ": " << outcome.err;
    };
    const std::string all = "palpate --help";
    expect("simulat torus.yaml -o s", "palpate: unknown command \"simulat\"; did you mean \"simulate\"?", all);
    expect("chekc", "palpate: unknown command \"chekc\"; did you mean \"check\"?", all);
    expect("help", "palpate: unknown command \"help\"; did you mean \"palpate --help\"?", all);
    expect("help check", "palpate: unknown command \"help\"; did you mean \"palpate --help\"?", all);
    expect("version", "palpate: unknown command \"version\"; did you mean \"palpate --version\"?", all);
    expect("nonsense", "palpate: unknown command \"nonsense\"", all);
    expect("--verison", "palpate: unknown option --verison; did you mean \"--version\"?", all);
    expect("simulate torus.yaml --ouput s", "palpate: simulate has no option --ouput; did you mean \"--output\"?",
           "palpate simulate --help");
    expect("simulate --ouput=s torus.yaml", "palpate: simulate has no option --ouput=s; did you mean \"--output\"?",
           "palpate simulate --help");
    expect("simulate torus.yaml -o s --anytime", "palpate: simulate has no option --anytime", "palpate simulate --help");
    expect("check torus.yaml more.yaml", "palpate: one word too many for check: more.yaml", "palpate check --help");
    expect("simulate torus.yaml", "palpate simulate: --output is required", "palpate simulate --help");
    EXPECT_FALSE(fs::exists(folder_ / "s"));
}

TEST_F(CommandLine, WithoutAWordItSaysWhatItIsAndWhichCommandsItHas) {
    const Outcome outcome = palpate("");
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_THAT(outcome.err, ::testing::StartsWith("Palpate discovers the shape of an unknown solid by touching it.\n"));
    for (const std::string command :
         {"simulate", "probe", "resume", "export", "inspect", "picture", "touch", "calibrate", "setup", "ports", "vm", "check", "bench"}) {
        EXPECT_THAT(outcome.err, HasSubstr("\n  " + command + " ")) << "a line of its own";
    }
    EXPECT_THAT(outcome.err, HasSubstr("palpate --help"));
    EXPECT_LE(std::ranges::count(outcome.err, '\n'), 18) << "short";
}

TEST_F(CommandLine, AnOptionIsNoNameOfAFolder) {
    write_torus();
    for (const std::string words : {"simulate torus.yaml -o --force", "simulate torus.yaml --output --no-picture",
                                    "bench torus.yaml -o --force", "probe torus.yaml -o --yes"}) {
        const Outcome outcome = palpate(words);
        EXPECT_EQ(outcome.exit_code, 2) << words;
        EXPECT_THAT(outcome.err, HasSubstr("looks like an option; give a name")) << words;
    }
    EXPECT_FALSE(fs::exists(folder_ / "--force"));
    EXPECT_EQ(palpate("simulate torus.yaml -o ./-odd --no-picture").exit_code, 0) << "as the message says";
    EXPECT_TRUE(fs::exists(folder_ / "-odd"));
}

TEST_F(CommandLine, SimulateLeavesACompleteSession) {
    write_torus();
    const Outcome outcome = palpate("simulate torus.yaml -o session");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("certificate    conditional"));
    EXPECT_THAT(outcome.err, ::testing::Not(HasSubstr("\r"))) << "no rewriting of lines in a pipe";
    for (const char* file : {"config.yaml", "mesh.ply", "touches.csv", "summary.json", "picture.png"}) {
        EXPECT_TRUE(fs::file_size(folder_ / "session" / file) > 0) << file;
    }
    const auto summary = nlohmann::json::parse(read("session/summary.json"));
    EXPECT_EQ(summary.at("euler_characteristic"), 0);
    EXPECT_EQ(summary.at("components"), 1);
    EXPECT_EQ(summary.at("truth").at("unsafe_moves"), 0);
    EXPECT_EQ(summary.at("probes").at("total"),
              summary.at("probes").at("contact").get<int>() + summary.at("probes").at("clear").get<int>());
    EXPECT_NEAR(summary.at("displacement").at("total").get<double>(), summary.at("truth").at("distance").get<double>(), 1e-6);
    // The folder describes itself: its own configuration gives the same touches, byte for byte.
    ASSERT_EQ(palpate("simulate session/config.yaml -o again").exit_code, 0);
    EXPECT_EQ(read("session/touches.csv"), read("again/touches.csv"));
    EXPECT_EQ(read("session/mesh.ply"), read("again/mesh.ply"));
}

TEST_F(CommandLine, SimulateMovesAWholeToolAndComparesNothingWithTheObjectAlone) {
    write("cube.yaml",
          "object: {shape: {rounded_box: {size: [4, 4, 4], fillet: 0}}}\ntool: {ball: {diameter: 2}}\nprobing: {epsilon: 1, reach: 0.9}\n");
    const Outcome outcome = palpate("simulate cube.yaml -o session --no-picture");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("0 unsafe moves, 0 into the object and 0 into fixtures; "));
    const auto summary = nlohmann::json::parse(read("session/summary.json"));
    EXPECT_EQ(summary.at("euler_characteristic"), 2);
    EXPECT_EQ(summary.at("truth").at("unsafe_moves"), 0);
    EXPECT_EQ(summary.at("truth").at("wrong_inferences"), 0);
    EXPECT_FALSE(summary.at("truth").contains("hausdorff"));
    EXPECT_GT(summary.at("truth").at("tool").at("touches").at("ball").at("object"), 50);
    EXPECT_THAT(read("session/config.yaml"), HasSubstr("tool: {ball: {diameter: 2}}\n"));
    EXPECT_EQ(palpate("bench cube.yaml -o table").exit_code, 2);
}

TEST_F(CommandLine, CheckTellsOfTheToolAndTheFixtures) {
    write(
        "cube.yaml",
        "object: {shape: {rounded_box: {size: [4, 4, 4], fillet: 0}, at: [0, 0, 2]}}\n"
        "tool: {ball: {diameter: 2}, stylus: {diameter: 1.5, length: 30}, holder: {diameter: 9, length: 20}}\n"
        "workspace:\n  box: {min: [-6, -6, -1], max: [6, 6, 9]}\n  fixtures: [{table: {z: 0}}, {box: {min: [4, -2, 0], max: [5, 2, 2]}}]\n"
        "probing: {epsilon: 1}\n");
    const Outcome outcome =
        palpate("check cube.yaml --offline --set 'machine={grbl: {port: /dev/null}, limits: {min: [-20, -20, -20], max: [20, 20, 20]}}'");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("tool           ball of 2 mm, stylus of 1.5 x 30 mm towards (0, 0, 1), holder of 9 x 20 mm\n"));
    EXPECT_THAT(outcome.out,
                HasSubstr("fixtures       table at z = 0 mm, box (4, -2, 0) mm to (5, 2, 2) mm; nothing but the part stands on them\n"));
    const Outcome narrow = palpate("check cube.yaml --set workspace.box.max=[6,6,4.5]");
    EXPECT_EQ(narrow.exit_code, 2);
    EXPECT_THAT(narrow.err, HasSubstr("workspace: not all places where the tool may touch the object are well inside it"));
    const Outcome curved = palpate("check cube.yaml --set 'object.shape={torus: {major: 2, minor: 1}}'");
    EXPECT_EQ(curved.exit_code, 2);
    EXPECT_THAT(curved.err, HasSubstr("object: with a tool that has a body, meshes, spheres, capsules, rounded boxes"));
}

// The same bytes wherever the tree stands, and a tree that is moved still works.
TEST_F(CommandLine, ASessionNamesItsMeshAsSeenFromItsFolder) {
    for (const std::string tree : {"here", "else/where"}) {
        fs::create_directories(folder_ / tree / "meshes");
        fs::copy_file(std::string(PALPATE_TEST_DATA) + "/cases/asc_name_facet.stl", folder_ / tree / "meshes/part.stl");
        write(tree + "/part.yaml", "object: {mesh: meshes/part.stl}\nprobing: {epsilon: 6}\n");
        const Outcome outcome = palpate("simulate " + tree + "/part.yaml -o " + tree + "/session --no-picture");
        ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    }
    EXPECT_THAT(read("here/session/config.yaml"), HasSubstr("mesh: \"../meshes/part.stl\""));
    for (const std::string file : {"config.yaml", "mesh.ply", "touches.csv"}) {
        EXPECT_EQ(read("here/session/" + file), read("else/where/session/" + file)) << file;
    }
    fs::rename(folder_ / "here", folder_ / "moved");
    const Outcome again = palpate("simulate moved/session/config.yaml -o moved/again --no-picture");
    ASSERT_EQ(again.exit_code, 0) << again.err;
    EXPECT_EQ(read("moved/session/mesh.ply"), read("moved/again/mesh.ply"));
}

TEST_F(CommandLine, WhatABudgetEndedIsIncompleteEverywhere) {
    write_torus(0.1);
    const Outcome outcome = palpate("simulate torus.yaml -o s --no-picture --set probing.budget.probes=100");
    EXPECT_EQ(outcome.exit_code, 4);
    EXPECT_THAT(outcome.out, HasSubstr("the budget of 100 probes ended the run"));
    EXPECT_THAT(outcome.out, ::testing::Not(HasSubstr("can be reached"))) << "most was not probed";
    EXPECT_THAT(outcome.err, HasSubstr(" %, "));
    EXPECT_THAT(outcome.err, ::testing::Not(HasSubstr("100 %")));
    const auto summary = nlohmann::json::parse(read("s/summary.json"));
    EXPECT_EQ(summary.at("complete"), false);
    EXPECT_EQ(summary.at("certificate").at("status"), "incomplete");

    const Outcome whole = palpate("simulate torus.yaml -o t --no-picture");
    EXPECT_EQ(whole.exit_code, 0);
    EXPECT_THAT(whole.err, HasSubstr("100 %"));
    EXPECT_EQ(nlohmann::json::parse(read("t/summary.json")).at("complete"), true);
}

TEST_F(CommandLine, ABoundThatTouchesRefuteIsExitCode5) {
    write_torus(0.05);
    const Outcome outcome = palpate("simulate torus.yaml -o s --no-picture --set probing.reach=0.8");
    EXPECT_EQ(outcome.exit_code, 5) << outcome.out;
    EXPECT_EQ(nlohmann::json::parse(read("s/summary.json")).at("certificate").at("status"), "refuted");
    EXPECT_EQ(palpate("bench torus.yaml --strategy default --set probing.reach=0.8 -o b").exit_code, 5);
    EXPECT_EQ(palpate("simulate torus.yaml -o t --no-picture --set probing.reach=0.8 --set probing.budget.probes=100").exit_code, 4)
        << "nothing is established";
}

TEST_F(CommandLine, PicturesAreDrawnOnRequest) {
    write_torus(0.3);
    const Outcome without = palpate("simulate torus.yaml -o s --no-picture");
    ASSERT_EQ(without.exit_code, 0) << without.err;
    EXPECT_THAT(without.out, HasSubstr("written to     s: config.yaml, mesh.ply, touches.csv, summary.json, surface.ply\n"));
    EXPECT_FALSE(fs::exists(folder_ / "s/picture.png"));
    const Outcome drawn = palpate("picture s --up x");
    EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
    EXPECT_EQ(drawn.out, "written to     s/picture.png\n");
    ASSERT_EQ(palpate("simulate torus.yaml -o same --up x").exit_code, 0);
    EXPECT_EQ(read("s/picture.png"), read("same/picture.png"));

    const Outcome refused = palpate("picture nowhere");
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_THAT(refused.err, HasSubstr("nowhere/mesh.ply: no such file"));
}

TEST_F(CommandLine, SummaryKeepsItsContract) {
    write_torus(0.3);
    ASSERT_EQ(palpate("simulate torus.yaml -o s").exit_code, 0);
    const auto summary = nlohmann::json::parse(read("s/summary.json"));
    const auto contract = nlohmann::json::parse(R"({"schema": 1, "program": {"name": "", "version": ""},
        "configuration": {"digest": ""}, "object": {"shape": ""}, "complete": true, "samples": 0, "facets": 0, "components": 0, "euler_characteristic": 0,
        "boundary_edges": 0, "nonmanifold_edges": 0, "epsilon": 0.0, "max_ball_radius": 0.0, "max_plausible_ball_radius": 0.0,
        "probes": {"total": 0, "contact": 0, "clear": 0, "inferred_contact": 0, "plausible_contact": 0, "inferred_clear": 0, "seed": 0},
        "displacement": {"total": 0.0, "travel": 0.0, "probing": 0.0}, "lower_bounds": {"samples": 0, "displacement": 0.0},
        "certificate": {"status": "", "premises": [{"name": "", "state": "", "detail": ""}]},
        "time": {"planner": 0.0, "oracle": 0.0, "machine_estimate": 0.0},
        "truth": {"hausdorff": 0.0, "mean_distance": 0.0, "euler_characteristic": 0, "wrong_facets": 0, "flipped_facets": 0, "wrong_inferences": 0, "unsafe_moves": 0}})");
    const auto flat = contract.flatten();
    for (const auto& [pointer, value] : flat.items()) {
        const nlohmann::json::json_pointer key(pointer);
        ASSERT_TRUE(summary.contains(key)) << pointer;
        EXPECT_EQ(summary.at(key).is_string(), value.is_string()) << pointer;
        EXPECT_EQ(summary.at(key).is_number_float(), value.is_number_float()) << pointer;
    }
    EXPECT_EQ(summary.at("schema"), 1);
    EXPECT_EQ(summary.at("object").at("shape"), "torus");
}

TEST_F(CommandLine, ResultsTellProgramConfigurationAndObject) {
    // What `sha256sum` says.
    fs::copy_file(std::string(PALPATE_TEST_DATA) + "/cases/asc_name_facet.stl", folder_ / "part.stl");
    const std::string hash = "e39701be5b4bbbfa39432a16492dc0dbaf76fd8b3bd196e8176c7c3e8157340a";
    write("part.yaml", "object: {mesh: part.stl}\nprobing: {epsilon: 6}\n");
    ASSERT_EQ(palpate("simulate part.yaml -o s --no-picture").exit_code, 0);
    const auto summary = nlohmann::json::parse(read("s/summary.json"));
    EXPECT_EQ(summary.at("program").at("name"), "palpate");
    const auto version = summary.at("program").at("version").get<std::string>();
    EXPECT_EQ(palpate("--version").out, version + "\n");
    EXPECT_EQ(summary.at("object").at("mesh"), "../part.stl");
    EXPECT_EQ(summary.at("object").at("sha256"), hash);
    const std::string digest_text = digest(read("s/config.yaml"));
    EXPECT_EQ(summary.at("configuration").at("digest"), digest_text);
    const std::string mesh = read("s/mesh.ply");
    EXPECT_THAT(mesh, HasSubstr("\ncomment made by Palpate " + version + "; millimetres\ncomment configuration: CRC-32 " + digest_text +
                                "\ncomment object: SHA-256 " + hash + "\nelement vertex"));
    EXPECT_THAT(mesh, ::testing::Not(HasSubstr(folder_.string())));

    // A mesh that is not whole says so wherever it goes.
    ASSERT_EQ(palpate("simulate part.yaml -o t --no-picture --set probing.budget.probes=40").exit_code, 4);
    EXPECT_THAT(read("t/mesh.ply"), HasSubstr("\ncomment incomplete: Nothing is guaranteed: the budget of"));
    EXPECT_EQ(palpate("picture t").exit_code, 0) << "comments are read over";
}

TEST_F(CommandLine, ASessionIsNotOverwrittenUnlessForced) {
    write_torus(0.3);
    ASSERT_EQ(palpate("simulate torus.yaml -o s").exit_code, 0);
    const std::string before = read("s/summary.json");
    const Outcome refused = palpate("simulate torus.yaml -o s");
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_THAT(refused.err, HasSubstr("--force"));
    EXPECT_EQ(read("s/summary.json"), before);
    EXPECT_EQ(palpate("simulate torus.yaml -o s --force --set probing.epsilon=0.25").exit_code, 0);
    EXPECT_NE(read("s/summary.json"), before);
}

TEST_F(CommandLine, MistakesAreSaidOnce) {
    const auto expect = [&](const std::string& config, const std::string& message) {
        write("bad.yaml", config);
        const Outcome outcome = palpate("simulate bad.yaml -o nowhere");
        EXPECT_EQ(outcome.exit_code, 2) << config;
        EXPECT_THAT(outcome.err, HasSubstr(message)) << config;
        EXPECT_FALSE(fs::exists(folder_ / "nowhere")) << config;
    };
    expect("object: {shape: {sphere: {radius: 1}}}\nprobing: {epsilon: -1}\n", "bad.yaml:2: probing.epsilon");
    expect("object: {mesh: missing.off}\nprobing: {epsilon: 1}\n", "missing.off");
    expect("probing: {epsilon: 1}\n", "object: missing");
    expect("object: {shape: {sphere: {radius: 1}}}\nworkspace: {ball: {center: [0, 0, 0], radius: 0.9}}\nprobing: {epsilon: 0.1}\n",
           "workspace: the object is not well inside it");
    const Outcome missed = palpate("check missing.yaml");
    EXPECT_EQ(missed.exit_code, 2);
    EXPECT_THAT(missed.err, HasSubstr("missing.yaml"));
}

TEST_F(CommandLine, MeshesAreMendedWithAWarningOrRefused) {
    const auto check = [&](const std::string& mesh, const std::string& more = "") {
        write("mesh.yaml", "object: {mesh: " + mesh + more + "}\nprobing: {epsilon: 5}\n");
        return palpate("check mesh.yaml");
    };
    const std::string cases = std::string(PALPATE_TEST_DATA) + "/cases/";
    const Outcome whole = check(cases + "asc_name_facet.stl");
    EXPECT_EQ(whole.exit_code, 0);
    EXPECT_EQ(whole.err, "");
    const Outcome mended = check(cases + "one_face_flipped.off", ", rotate: [0, 0, 90], at: [20, 0, 1]");
    EXPECT_EQ(mended.exit_code, 0);
    EXPECT_THAT(mended.err, HasSubstr("warning: " + cases + "one_face_flipped.off: 2 triangles that faced the other way"));
    EXPECT_THAT(mended.out, HasSubstr("(0, 0, 1) mm to (20, 20, 21) mm, 1 component(s), Euler characteristic 2"));
    const Outcome forbidden = check(cases + "one_face_flipped.off", ", repair: false");
    EXPECT_EQ(forbidden.exit_code, 2);
    EXPECT_THAT(forbidden.err, HasSubstr("needs repair, which object.repair forbids: 2 triangles that faced the other way"));

    write("open.off", "OFF\n4 3 0\n0 0 0\n3 0 0\n0 4 0\n0 0 5\n3 0 1 3\n3 1 2 3\n3 2 0 3\n");
    const Outcome open = check("open.off");
    EXPECT_EQ(open.exit_code, 2);
    EXPECT_THAT(open.err, HasSubstr("3 boundary edges around 1 hole; its boundary is 12 mm long and passes through (0, 0, 0) mm"));
    write("word.off", "OFF\n4 4 0\n0 0 0\n3 0 abc\n");
    const Outcome word = check("word.off");
    EXPECT_EQ(word.exit_code, 2);
    EXPECT_THAT(word.err, HasSubstr("word.off: line 4: 'abc' where a coordinate was expected"));
}

TEST_F(CommandLine, AnObjectThatNoSeedTouchesSaysWhatToGive) {
    write("far.yaml",
          "object: {shape: {sphere: {radius: 0.001}, at: [5, 5, 5]}}\nworkspace: {ball: {center: [0, 0, 0], radius: 10}}\nprobing: "
          "{epsilon: 0.0002}\n");
    const Outcome outcome = palpate("simulate far.yaml -o s");
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("seed_rays"));
    EXPECT_EQ(palpate("simulate far.yaml -o t --set 'probing.seed_rays=[{from: [5, 5, 9], to: [5, 5, 5]}]'").exit_code, 0);
}

TEST_F(CommandLine, CheckAndSimulateAgreeOnWhatCannotBegin) {
    write("small.yaml", "object: {shape: {sphere: {radius: 2}}}\nprobing: {epsilon: 0.5}\n");
    EXPECT_EQ(palpate("check small.yaml").exit_code, 0);
    for (const std::string words : {"--set probing.epsilon=50", "--set 'probing.seed_rays=[{from: [9, 9, 9], to: [9, 9, 0]}]'",
                                    "--set 'probing.seed_rays=[{from: [0, 0, 1], to: [0, 0, 0]}]'"}) {
        const Outcome check = palpate("check small.yaml " + words);
        const Outcome simulate = palpate("simulate small.yaml -o s " + words);
        EXPECT_EQ(simulate.exit_code, 2) << words;
        EXPECT_EQ(check.exit_code, 2) << words;
        EXPECT_THAT(simulate.err, ::testing::EndsWith(check.err)) << words;
        EXPECT_THAT(check.out, ::testing::Not(HasSubstr("good"))) << words;
    }
}

TEST_F(CommandLine, BenchComparesStrategies) {
    write_torus();
    const Outcome outcome = palpate("bench torus.yaml --strategy thesis,default,eager+exhaustive -o cmp");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("| thesis"));
    EXPECT_THAT(outcome.out, HasSubstr("| default "));
    const auto rows = nlohmann::json::parse(read("cmp.json"));
    ASSERT_EQ(rows.size(), 3U);
    EXPECT_LT(rows[1].at("probes").get<int>(), rows[0].at("probes").get<int>());
    std::istringstream csv(read("cmp.csv"));
    std::string line;
    std::size_t lines = 0;
    while (std::getline(csv, line)) {
        ++lines;
        EXPECT_EQ(std::count(line.begin(), line.end(), ',') + 1U, rows[0].size());
    }
    EXPECT_EQ(lines, 4U);
}

// Of a line of a CSV file whose words have no commas.
std::vector<std::string> fields_of(const std::string& line) {
    std::vector<std::string> fields;
    std::istringstream stream(line);
    for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
    return fields;
}

TEST_F(CommandLine, BenchWritesErrorsBeforeTheEnd) {
    write_torus(0.3);
    const Outcome outcome = palpate("bench torus.yaml --strategy default,adaptive --anytime -o any");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    std::istringstream csv(read("any.csv"));
    std::string line;
    std::getline(csv, line);
    EXPECT_EQ(
        line,
        "config,method,probes,displacement,facets,hausdorff,mean_distance,unsafe_moves,p99,euler_characteristic,boundary_edges,seconds");
    std::map<std::string, double> best;  // by method
    std::map<std::string, int> rows;
    while (std::getline(csv, line)) {
        const std::vector<std::string> fields = fields_of(line);
        ASSERT_EQ(fields.size(), 12U) << line;
        const double hausdorff = std::stod(fields[5]);
        const auto [known, is_new] = best.try_emplace(fields[1], hausdorff);
        known->second = std::min(known->second, hausdorff);
        ++rows[fields[1]];
        EXPECT_EQ(fields[7], "0") << "unsafe moves";
    }
    ASSERT_EQ(best.size(), 5U);
    for (const auto& [method, count] : rows) EXPECT_GE(count, 3) << method;
    EXPECT_LT(best.at("default"), best.at("random rays"));
    EXPECT_LT(best.at("default"), best.at("z-raster"));
    EXPECT_THAT(read("any.svg"), HasSubstr("</svg>"));
    EXPECT_EQ(palpate("bench torus.yaml torus.yaml --anytime -o two").exit_code, 2);
    EXPECT_EQ(palpate("bench torus.yaml --anytime -o any").exit_code, 2) << "nothing is replaced";
}

TEST_F(CommandLine, BenchTellsHowOftenPlausibleFacetsAreWrong) {
    write_torus(0.2);
    const Outcome outcome = palpate("bench torus.yaml --strategy adaptive --reliability -o r");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    std::istringstream csv(read("r.csv"));
    std::string line;
    std::getline(csv, line);
    EXPECT_EQ(line, "from,to,facets,stated,wrong,flips");
    std::uint64_t facets = 0;
    while (std::getline(csv, line)) {
        std::vector<double> fields;
        for (const std::string& field : fields_of(line)) fields.push_back(std::stod(field));
        ASSERT_EQ(fields.size(), 6U) << line;
        EXPECT_LE(fields[0], fields[3]);
        EXPECT_LE(fields[3], fields[1]);
        EXPECT_LE(fields[4] + fields[5], fields[2]);
        facets += static_cast<std::uint64_t>(fields[2]);
    }
    ASSERT_EQ(palpate("simulate torus.yaml --set probing.strategy=adaptive -o s --no-picture").exit_code, 0);
    EXPECT_EQ(nlohmann::json::parse(read("s/summary.json")).at("probes").at("plausible_contact"), facets);
    EXPECT_THAT(read("r.svg"), HasSubstr("</svg>"));
    EXPECT_EQ(palpate("bench torus.yaml --strategy thesis --reliability -o none").exit_code, 2) << "nothing is plausible only";
    EXPECT_EQ(palpate("bench torus.yaml --anytime --reliability -o both").exit_code, 2);
}

TEST_F(CommandLine, BenchReplacesNothingUnlessForced) {
    write_torus(0.3);
    write("mine.csv", "precious");
    const Outcome refused = palpate("bench torus.yaml --strategy default -o mine");
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_THAT(refused.err, HasSubstr("--force"));
    EXPECT_EQ(read("mine.csv"), "precious");
    EXPECT_EQ(palpate("bench torus.yaml missing.yaml --strategy default -o other").exit_code, 2);
    EXPECT_FALSE(fs::exists(folder_ / "other.csv"));
    EXPECT_EQ(palpate("bench torus.yaml --strategy default -o mine --force").exit_code, 0);
    EXPECT_NE(read("mine.csv"), "precious");
}

TEST_F(CommandLine, AFailedRunLeavesTheOldSessionWhole) {
    write_torus(0.3);
    ASSERT_EQ(palpate("simulate torus.yaml -o s").exit_code, 0);
    const std::string before = read("s/config.yaml");
    EXPECT_EQ(palpate("simulate torus.yaml -o s --force --set probing.epsilon=9").exit_code, 2);
    EXPECT_EQ(read("s/config.yaml"), before);
    // Nor does one that never was stand in the way of the next.
    EXPECT_EQ(palpate("simulate torus.yaml -o t --set probing.epsilon=9").exit_code, 2);
    EXPECT_EQ(palpate("simulate torus.yaml -o t").exit_code, 0);
}

TEST_F(CommandLine, AFalseReachAndAnotherTruthAreWarnedOf) {
    write_torus(0.3);
    EXPECT_THAT(palpate("check torus.yaml --set probing.reach=5").err, HasSubstr("more than the object's true reach"));
    write("thin.yaml", "object: {shape: {torus: {major: 1, minor: 0.05}}}\nprobing: {epsilon: 0.1}\n");
    EXPECT_THAT(palpate("simulate thin.yaml -o thin").err, HasSubstr("Euler characteristic"));
}

TEST_F(CommandLine, AFullStandardOutputIsAnError) {
    write_torus(0.3);
    if (!fs::exists("/dev/full")) GTEST_SKIP();
    const std::string command = "cd '" + folder_.string() + "' && '" PALPATE_EXECUTABLE "' check torus.yaml >/dev/full 2>err.txt";
    const int status = std::system(command.c_str());
    EXPECT_EQ(WEXITSTATUS(status), 2);
    EXPECT_THAT(read("err.txt"), HasSubstr("standard output"));
}

TEST_F(CommandLine, HelpThatCannotBeWrittenIsAnError) {
    if (!fs::exists("/dev/full")) GTEST_SKIP();
    for (const std::string words : {"--help", "--version", "simulate --help", "check --help", "bench --help"}) {
        const std::string command = "cd '" + folder_.string() + "' && '" PALPATE_EXECUTABLE "' " + words + " >/dev/full 2>err.txt";
        const int status = std::system(command.c_str());
        EXPECT_EQ(WEXITSTATUS(status), 2) << words;
        EXPECT_THAT(read("err.txt"), HasSubstr("standard output")) << words;
    }
}

TEST_F(CommandLine, AComponentThatIsOnlyTouchedIsFoundAsWell) {
    write("two.yaml",
          "object: {shape: {union: {parts: [{rounded_box: {size: [1, 1, 1], fillet: 0}}, {rounded_box: {size: [1, 1, 1], fillet: 0}, at: "
          "[3, 0, 0]}]}}}\n"
          "probing: {epsilon: 0.3, strategy: {infer: none}}\n");
    // Only walks come by the other one.
    const Outcome outcome = palpate("simulate two.yaml -o two");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.out;
    EXPECT_EQ(nlohmann::json::parse(read("two/summary.json")).at("components"), 2);
}

TEST_F(CommandLine, AFineEpsilonInALargeWorkspaceRuns) {
    write("fine.yaml",
          "object: {shape: {sphere: {radius: 0.1}}}\nworkspace: {ball: {center: [0, 0, 0], radius: 1000}}\nprobing: {epsilon: 0.015}\n");
    EXPECT_EQ(palpate("simulate fine.yaml -o fine").exit_code, 0);
}

TEST_F(CommandLine, CheckMovesNothingAndSaysWhatIsNeeded) {
    write_torus(0.1);
    const Outcome outcome = palpate("check torus.yaml");
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_THAT(outcome.out, HasSubstr("needs a reach of at least 0.625 mm"));
}

TEST_F(CommandLine, AFolderThatCannotBeWrittenIsSaidBeforeTheRun) {
    write_torus();
    write("file", "in the way");
    const Outcome outcome = palpate("simulate torus.yaml -o file/session");
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("file/session"));
}

}  // namespace
}  // namespace palpate::command_line_test
