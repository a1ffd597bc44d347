// Sessions as a user runs them: the program itself, on a serial port behind which a virtual machine is that hides a sphere.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "devices/posix/tcp_stream.h"
#include "sim/machines/grbl/grbl_host.h"
#include "sim/objects/hidden_object.h"

namespace palpate {

namespace fs = std::filesystem;

inline constexpr double kRadius = 5.0;
inline const Point kOrigin(-60, -50, -40);  // machine coordinates of the sphere's centre
inline const Point kAbove = kOrigin + Point(0, 0, 14);

inline VirtualToolOptions axes() {
    VirtualToolOptions options;
    options.motion.retract_mm = 0.2;
    options.origin = kOrigin;
    options.start = kAbove;
    options.limits = {kOrigin - Vector::Constant(16), Point::Zero()};
    return options;
}

// For PortMachine: a free port of this computer's own network, which host().client_path() tells then.
inline const fs::path kNetwork = "tcp://127.0.0.1:0";

// A virtual machine on a serial port or on the network, and the object that it hides.
class PortMachine {
public:
    PortMachine(const fs::path& link, VirtualGrblOptions options = {}, const VirtualToolOptions& axes = palpate::axes(),
                const ShapeSpec& shape = {SphereSpec{kRadius}})
        : object_(shape),
          tool_(object_, axes),
          grbl_options_(with_home(std::move(options), axes)),
          grbl_(tool_, grbl_options_),
          host_(grbl_, host_options(link, grbl_options_.dialect)) {}

    [[nodiscard]] GrblHost& host() { return host_; }
    [[nodiscard]] VirtualToolAudit audit() {
        VirtualToolAudit audit;
        host_.with([&](VirtualGrbl&) { audit = tool_.audit(); });
        return audit;
    }
    [[nodiscard]] std::uint64_t probes() {
        std::uint64_t probes = 0;
        host_.with([&](VirtualGrbl& grbl) { probes = grbl.counts().probes; });
        return probes;
    }
    [[nodiscard]] bool place_by_hand(const Point& machine) {
        bool placed = false;
        host_.with([&](VirtualGrbl& grbl) {
            if (tool_.is_moving() || grbl.is_busy()) return;
            tool_.place(machine);
            placed = true;
        });
        return placed;
    }
    // As an operator does before homing a machine that has lost its position.
    void move_out_by_hand() {
        host_.with([&](VirtualGrbl&) {
            if (!tool_.is_moving()) tool_.place(kAbove);
        });
    }

private:
    static VirtualGrblOptions with_home(VirtualGrblOptions options, const VirtualToolOptions& axes) {
        options.homed_position = axes.start;
        options.soft_limits = true;
        return options;
    }

    static GrblHostOptions host_options(const fs::path& link, GrblDialect dialect) {
        GrblHostOptions options{link, GrblHostOptions::Time::fast, false};
        if (const auto address = parse_tcp_address(link.string())) {
            options.tcp_port = address->port;
            options.greets_clients = dialect == GrblDialect::grblhal;
        }
        return options;
    }

    HiddenObject object_;
    VirtualTool tool_;
    VirtualGrblOptions grbl_options_;
    VirtualGrbl grbl_;
    GrblHost host_;
};

class SessionRig : public ::testing::Test {
protected:
    SessionRig() {
        std::string name = (fs::temp_directory_path() / "palpate_session_XXXXXX").string();
        folder_ = mkdtemp(name.data());
        write("part.yaml", "grbl: {port: " + port().string() + "}\n  homing: run");
    }
    ~SessionRig() override { fs::remove_all(folder_); }

    [[nodiscard]] fs::path port() const { return folder_ / "tty"; }
    void write(const std::string& name, const std::string& connection) const {
        std::ofstream(folder_ / name) << "machine:\n  " << connection << "\n"
                                      << "  origin: [-60, -50, -40]\n  limits: {min: [-15, -15, -15], max: [15, 15, 15]}\n"
                                         "  retract: 0.2\nworkspace: {ball: {center: [0, 0, 0], radius: 7}}\n"
                                         "probing: {epsilon: 2, reach: 4.9}\n";
    }
    [[nodiscard]] std::string read(const fs::path& file) const {
        std::ifstream in(folder_ / file, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    }

    // A running palpate.
    class Process {
    public:
        Process(const fs::path& folder, const std::vector<std::string>& words, rlim_t largest_file = RLIM_INFINITY) {
            std::vector<std::string> all = words;
            all.insert(all.begin(), PALPATE_EXECUTABLE);
            std::vector<char*> argv;
            for (std::string& word : all) argv.push_back(word.data());
            argv.push_back(nullptr);
            const std::string out = (folder / "out.txt").string();
            id_ = fork();
            if (id_ != 0) return;
            // Only what may be called between fork and exec.
            ::signal(SIGHUP, SIG_DFL);  // nohup would have it ignored
            setsid();                   // nobody sits at the terminal of the tests
            const int file = open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
            dup2(file, STDOUT_FILENO);
            dup2(file, STDERR_FILENO);
            close(STDIN_FILENO);
            if (largest_file != RLIM_INFINITY) {
                signal(SIGXFSZ, SIG_IGN);
                const rlimit limit{largest_file, largest_file};
                setrlimit(RLIMIT_FSIZE, &limit);
            }
            if (chdir(folder.c_str()) == 0) execv(argv[0], argv.data());
            _exit(127);
        }
        [[nodiscard]] pid_t id() const { return id_; }
        void send(int signal) const { kill(id_, signal); }
        // Exit code; 128 and the signal if one ended it.
        [[nodiscard]] int wait() {
            int status = 0;
            waitpid(id_, &status, 0);
            return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
        }

    private:
        pid_t id_ = 0;
    };
    [[nodiscard]] Process start(const std::vector<std::string>& words, rlim_t largest_file = RLIM_INFINITY) const {
        return {folder_, words, largest_file};
    }
    int run(const std::vector<std::string>& words) const { return start(words).wait(); }
    [[nodiscard]] std::vector<std::string> probe(const std::string& session) const {
        return {"probe", "part.yaml", "-o", session, "--yes"};
    }
    [[nodiscard]] std::vector<std::string> resume(const std::string& session) const { return {"resume", session, "--yes"}; }

    // Until the machine has seen so many, or for 20 s.
    static void wait_for_probes(PortMachine& machine, std::uint64_t probes) {
        for (int k = 0; k < 20'000 && machine.probes() < probes; ++k) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        ASSERT_GE(machine.probes(), probes);
    }
    static void expect_safe(PortMachine& machine) {
        const VirtualToolAudit audit = machine.audit();
        EXPECT_EQ(audit.unguarded_moves, 0U);
        EXPECT_EQ(audit.outside_limits, 0U);
        EXPECT_EQ(audit.unsafe_moves, 0U);
    }

    fs::path folder_;
};

}  // namespace palpate
