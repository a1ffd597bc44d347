// Speed of the planner as ratios in one run: absolute times mean little on a shared machine.
//
//   planner / insertion   the planner's time without the oracle, by plain incremental insertion of the same samples in the
//                         same order, with a locate hint, into a Delaunay_triangulation_3
//   planner / mesher      the same, by CGAL's make_surface_mesh with a full oracle at the same epsilon
//   scaling               time per sample at about 55,000 samples, by that at 14,000
#define CGAL_NO_DEPRECATION_WARNINGS
#include <CGAL/Complex_2_in_triangulation_3.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Implicit_surface_3.h>
#include <CGAL/Surface_mesh_default_criteria_3.h>
#include <CGAL/Surface_mesh_default_triangulation_3.h>
#include <CGAL/make_surface_mesh.h>
#include <benchmark/benchmark.h>

#include <chrono>

#include "devices/device_oracle.h"
#include "devices/timed_oracle.h"
#include "planner/probe_surface.h"
#include "sim/objects/hidden_object.h"
#include "sim/simulated_device.h"

namespace palpate {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kMajor = 1.0;
constexpr double kMinor = 0.4;
constexpr double kWorkspaceRadius = 1.6;
// Samples of the torus at these: about 4,400, 17,600 and 70,000 by walks; a fifth fewer by growth.
constexpr double kSmall = 0.05;
constexpr double kMiddle = 0.025;
constexpr double kLarge = 0.0125;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

struct TimedRun {
    std::vector<Point> samples;  // in order of insertion
    double planner_seconds = 0.0;
    std::size_t probes = 0;

    double microseconds_per_sample() const { return 1e6 * planner_seconds / static_cast<double>(samples.size()); }
};

TimedRun run_planner(double epsilon, const Strategy& strategy) {
    const HiddenObject object{ObjectSpec(ShapeSpec{TorusSpec{kMajor, kMinor}})};
    SimulatedDevice device(object, {0, 0, kWorkspaceRadius}, {.audit = false});
    DeviceOracle device_oracle(device);
    TimedOracle oracle(device_oracle);
    Options options;
    options.epsilon = epsilon;
    options.reach = kMinor;
    options.strategy = strategy;
    const auto start = Clock::now();
    const Result result = probe_surface(oracle, Region(Ball{Point::Zero(), kWorkspaceRadius}), options);
    TimedRun run;
    run.planner_seconds = seconds_since(start) - oracle.spent().count();
    run.probes = result.cost.probes();
    run.samples.resize(result.samples);
    for (const Touch& touch : result.touches) {
        if (touch.sample) run.samples[*touch.sample] = touch.position;
    }
    return run;
}

double plain_insertion_seconds(const std::vector<Point>& samples) {
    using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    using Delaunay = CGAL::Delaunay_triangulation_3<Kernel>;
    const auto start = Clock::now();
    Delaunay delaunay;
    Delaunay::Vertex_handle last;
    for (const Point& p : samples) {
        const Kernel::Point_3 point(p.x(), p.y(), p.z());
        last = last == Delaunay::Vertex_handle() ? delaunay.insert(point) : delaunay.insert(point, last);
    }
    benchmark::DoNotOptimize(delaunay.number_of_vertices());
    return seconds_since(start);
}

double surface_mesher_seconds(double epsilon, std::size_t& samples) {
    using Triangulation = CGAL::Surface_mesh_default_triangulation_3;
    using Complex = CGAL::Complex_2_in_triangulation_3<Triangulation>;
    using Traits = Triangulation::Geom_traits;
    using Function = Traits::FT (*)(Traits::Point_3);
    const auto start = Clock::now();
    Triangulation triangulation;
    Complex complex(triangulation);
    const Function torus = [](Traits::Point_3 p) {
        const double flat = std::sqrt(p.x() * p.x() + p.y() * p.y()) - kMajor;
        return flat * flat + p.z() * p.z() - kMinor * kMinor;
    };
    // The sphere's centre must be inside the surface.
    const CGAL::Implicit_surface_3<Traits, Function> surface(torus, Traits::Sphere_3(Traits::Point_3(kMajor, 0, 0), 7.0), 1e-6);
    constexpr double kNoBound = 1e9;
    const CGAL::Surface_mesh_default_criteria_3<Triangulation> criteria(0.0, epsilon, kNoBound);
    CGAL::make_surface_mesh(complex, surface, criteria, CGAL::Non_manifold_tag());
    samples = triangulation.number_of_vertices();
    return seconds_since(start);
}

void planner_by_insertion(benchmark::State& state, double epsilon, const Strategy& strategy) {
    for (auto _ : state) {
        const TimedRun run = run_planner(epsilon, strategy);
        const double insertion = plain_insertion_seconds(run.samples);
        state.SetIterationTime(run.planner_seconds);
        state.counters["samples"] = static_cast<double>(run.samples.size());
        state.counters["probes"] = static_cast<double>(run.probes);
        state.counters["us/sample"] = run.microseconds_per_sample();
        state.counters["planner/insertion"] = run.planner_seconds / insertion;
    }
}

void planner_by_mesher(benchmark::State& state, double epsilon) {
    for (auto _ : state) {
        const TimedRun run = run_planner(epsilon, Strategy{});
        std::size_t samples = 0;
        const double mesher = surface_mesher_seconds(epsilon, samples);
        state.SetIterationTime(run.planner_seconds);
        state.counters["samples"] = static_cast<double>(run.samples.size());
        state.counters["mesher_samples"] = static_cast<double>(samples);
        state.counters["planner/mesher"] = run.planner_seconds / mesher;
    }
}

void scaling(benchmark::State& state) {
    for (auto _ : state) {
        const TimedRun middle = run_planner(kMiddle, Strategy{});
        const TimedRun large = run_planner(kLarge, Strategy{});
        state.SetIterationTime(large.planner_seconds);
        state.counters["samples"] = static_cast<double>(large.samples.size());
        state.counters["us/sample"] = large.microseconds_per_sample();
        state.counters["scaling"] = large.microseconds_per_sample() / middle.microseconds_per_sample();
        state.counters["planner/insertion"] = large.planner_seconds / plain_insertion_seconds(large.samples);
    }
}

const auto kDefault = Strategy{};
const Strategy kWalks{Strategy::Refine::eager, Strategy::Explore::closure, Strategy::Infer::none, Strategy::Travel::voronoi};
const auto kThesis = Strategy::thesis();
BENCHMARK_CAPTURE(planner_by_insertion, walks_4400, kSmall, kWalks)->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(3);
BENCHMARK_CAPTURE(planner_by_insertion, walks_17600, kMiddle, kWalks)->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(3);
BENCHMARK_CAPTURE(planner_by_insertion, default_3500, kSmall, kDefault)->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(5);
BENCHMARK_CAPTURE(planner_by_insertion, default_14000, kMiddle, kDefault)->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(3);
BENCHMARK_CAPTURE(planner_by_insertion, thesis_4400, kSmall, kThesis)->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(3);
BENCHMARK_CAPTURE(planner_by_mesher, default_14000, kMiddle)->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK(scaling)->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
