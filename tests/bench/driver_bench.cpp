// What a probe costs besides the machine's motion: the real serial driver on a pseudo-terminal, behind which a virtual GRBL controller
// moves in no time. A probe here is a travel, a touch, a slow touch to confirm it, and the retracts: some seven commands with their
// reports.
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>

#include "devices/decorators/multi_touch_device.h"
#include "devices/grbl/grbl_device.h"
#include "devices/posix/serial_port.h"
#include "devices/session/journaling_device.h"
#include "sim/machines/grbl/grbl_host.h"
#include "sim/objects/hidden_object.h"

namespace {

using namespace palpate;

constexpr int kProbes = 500;

// Seconds of this thread.
double cpu_time() {
    rusage usage{};
    getrusage(RUSAGE_THREAD, &usage);
    const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

void measure(const char* what, ProbeDevice& device) {
    const auto begin = std::chrono::steady_clock::now();
    const double cpu = cpu_time();
    int touches = 0;
    for (int k = 0; k < kProbes; ++k) {
        const double x = 0.002 * k;
        (void)device.guarded_move({x, 0, 12}, Pace::travel);
        touches += device.guarded_move({x, 0, 0}, Pace::probe).outcome == MoveResult::Outcome::contact ? 1 : 0;
    }
    const std::chrono::duration<double, std::milli> wall = std::chrono::steady_clock::now() - begin;
    std::printf("%-40s %6.2f ms per probe, %5.2f ms of them this thread's own (%d touches)\n", what, wall.count() / kProbes,
                1e3 * (cpu_time() - cpu) / kProbes, touches);
}

}  // namespace

int main() {
    const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("palpate_driver_bench_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder);
    const HiddenObject object(ShapeSpec{SphereSpec{5}});
    VirtualToolOptions axes;
    axes.start = {0, 0, 12};
    VirtualTool tool(object, axes);
    VirtualGrbl grbl(tool, {});
    const GrblHost host(grbl, {folder / "tty", GrblHostOptions::Time::fast, false});
    SerialPort port({(folder / "tty").string()});
    SteadyClock clock;
    GrblOptions options;
    GrblDevice device(port, clock, options);
    device.make_ready();
    MultiTouchDevice touching(device, {}, options.motion.retract_mm);
    measure("driver and touches", touching);
    const JournalHeader header{"", touching.position(), "bench"};
    JournalWriter writer = JournalWriter::create(folder / "journal.jsonl", header);
    JournalingDevice journaling(Journal{header}, &writer, [&](const Point&) -> ProbeDevice& { return touching; });
    measure("the same, with a durable journal", journaling);
    std::filesystem::remove_all(folder);
}
