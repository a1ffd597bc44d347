#include "tools/anytime.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <utility>

#include "config/strategy_names.h"
#include "devices/device_oracle.h"
#include "planner/baselines/baselines.h"
#include "planner/topology.h"
#include "sim/simulated_device.h"
#include "tools/curved_result.h"
#include "tools/view/line_plot.h"

namespace palpate {
namespace {

constexpr std::uint64_t kFewestProbes = 50;
constexpr std::uint64_t kMostBaselineProbes = 100'000;
constexpr const char* kRaster = "z-raster";
constexpr const char* kRandomRays = "random rays";
constexpr const char* kGaussianProcess = "Gaussian process";
constexpr std::uint64_t kMostProcessProbes = 500;  // 1,000 take a quarter of an hour
// Of the tolerance that is given.
constexpr std::array kTolerances{32.0, 16.0, 8.0, 4.0, 2.0, 1.0};

// Probes to stop after, on the way to `last`.
std::vector<std::uint64_t> budgets(std::uint64_t last) {
    std::vector<std::uint64_t> all;
    // 50, 100, 200, 500, 1000, ...
    for (std::uint64_t budget = kFewestProbes; budget < last; budget = all.size() % 3 == 0 ? budget / 2 * 5 : budget * 2) {
        all.push_back(budget);
    }
    return all;
}

Truth truth_of(const SessionConfig& config, const Scene& scene, const TriangleMesh& mesh) {
    return measure_truth(scene.object, mesh, TruthSampling{}, config.probing.random_seed);
}

// What the mesh is worth.
AnytimePoint judge(AnytimePoint point, const SessionConfig& config, const Scene& scene, const TriangleMesh& mesh, const Truth& truth) {
    const Topology topology = analyse_topology(mesh);
    point.facets = mesh.triangles.size();
    point.hausdorff = truth.hausdorff;
    point.mean_distance = truth.mean_distance;
    point.p99 = measure_surface(scene.object, mesh, kCurvedTruthPoints, config.probing.random_seed).p99;
    point.euler_characteristic = topology.euler_characteristic;
    point.boundary_edges = topology.boundary_edges + topology.nonmanifold_edges;
    return point;
}

AnytimePoint cost_of(const std::string& name, const std::string& method, const Simulation& run) {
    AnytimePoint point;
    point.config = name;
    point.method = method;
    point.probes = run.result.cost.probes();
    point.displacement = run.result.cost.displacement();
    point.unsafe_moves = run.unsafe_moves;
    point.seconds = run.planner_seconds;
    return point;
}

template <typename Probe>
AnytimePoint measure_baseline(const std::string& name, const char* method, const SessionConfig& config, const Scene& scene,
                              const Probe& probe) {
    const Region& workspace = scene.workspace.region();
    SimulatedDevice device(scene.object, workspace.nearest_boundary(workspace.center() + 2 * workspace.radius() * Vector::UnitZ()));
    DeviceOracle oracle(device);
    const auto start = std::chrono::steady_clock::now();
    const BaselineResult run = probe(oracle, workspace);
    AnytimePoint point;
    point.config = name;
    point.method = method;
    point.probes = run.cost.probes();
    point.displacement = run.cost.displacement();
    point.unsafe_moves = device.unsafe_moves();
    point.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return judge(std::move(point), config, scene, run.mesh, truth_of(config, scene, run.mesh));
}

}  // namespace

std::vector<AnytimePoint> measure_anytime(const std::string& name, SessionConfig config, const Scene& scene,
                                          const std::vector<Strategy>& strategies,
                                          const std::function<void(const AnytimePoint&)>& on_point) {
    std::vector<AnytimePoint> points;
    const auto add = [&](AnytimePoint point) {
        if (on_point) on_point(point);
        points.push_back(std::move(point));
    };
    std::uint64_t most = 0;
    const auto run = [&](const std::string& method, std::optional<std::uint64_t> budget) {
        SessionConfig bounded = config;
        if (budget) bounded.probing.budget.probes = *budget;
        const Simulation end = simulate(bounded, scene, {});
        add(judge(cost_of(name, method, end), config, scene, end.result.mesh, *end.truth));
        return end.result.cost.probes();
    };
    const std::optional<double> tolerance = std::exchange(config.probing.tolerance, std::nullopt);
    for (const Strategy& strategy : strategies) {
        config.probing.strategy = strategy;
        const std::uint64_t all = run(to_string(strategy), {});
        most = std::max(most, all);
        for (const std::uint64_t budget : budgets(all)) run(to_string(strategy), budget);
    }
    for (const double factor : kTolerances) {
        if (!tolerance) break;
        config.probing.tolerance = factor * *tolerance;
        const Simulation end = simulate(config, scene, {});
        const std::optional<CurvedSurface> curved = curved_of(end.result, {}, config);
        AnytimePoint point = cost_of(name, "to a tolerance", end);
        add(curved ? judge(std::move(point), config, scene, curved->mesh, truth_of(config, scene, curved->mesh))
                   : judge(std::move(point), config, scene, end.result.mesh, *end.truth));
        most = std::max(most, end.result.cost.probes());
    }
    std::vector<std::uint64_t> shared = budgets(std::min(most, kMostBaselineProbes));
    shared.push_back(std::min(most, kMostBaselineProbes));
    for (const std::uint64_t budget : shared) {
        add(measure_baseline(name, kRaster, config, scene,
                             [&](SurfaceOracle& oracle, const Region& workspace) { return probe_raster(oracle, workspace, budget); }));
    }
    for (const std::uint64_t budget : shared) {
        add(measure_baseline(name, kRandomRays, config, scene, [&](SurfaceOracle& oracle, const Region& workspace) {
            return probe_random_rays(oracle, workspace, budget, config.probing.random_seed);
        }));
    }
    for (const std::uint64_t budget : budgets(std::min(most, kMostProcessProbes + 1))) {
        add(measure_baseline(name, kGaussianProcess, config, scene, [&](SurfaceOracle& oracle, const Region& workspace) {
            return probe_gaussian_process(oracle, workspace, budget, config.probing.random_seed);
        }));
    }
    return points;
}

std::string anytime_csv(const std::vector<AnytimePoint>& points) {
    std::string text =
        "config,method,probes,displacement,facets,hausdorff,mean_distance,unsafe_moves,p99,euler_characteristic,boundary_edges,seconds\n";
    for (const AnytimePoint& p : points) {
        text +=
            fmt::format("{},{},{},{:.10g},{},{:.10g},{:.10g},{},{:.10g},{},{},{:.3g}\n", p.config, p.method, p.probes, p.displacement,
                        p.facets, p.hausdorff, p.mean_distance, p.unsafe_moves, p.p99, p.euler_characteristic, p.boundary_edges, p.seconds);
    }
    return text;
}

std::string anytime_svg(const std::vector<AnytimePoint>& points) {
    LinePlot plot;
    plot.y_label = "Hausdorff distance (mm)";
    plot.x_labels = {"probes", "displacement (mm)"};
    for (const AnytimePoint& p : points) {
        auto series = std::find_if(plot.series.begin(), plot.series.end(), [&](const PlotSeries& s) { return s.name == p.method; });
        if (series == plot.series.end()) series = plot.series.insert(series, {p.method, {{}, {}}});
        series->points[0].emplace_back(static_cast<double>(p.probes), p.hausdorff);
        series->points[1].emplace_back(p.displacement, p.hausdorff);
    }
    // A strategy's end is told first.
    for (PlotSeries& series : plot.series) {
        for (auto& curve : series.points) std::ranges::sort(curve);
    }
    if (!points.empty()) plot.title = fmt::format("Error before the end: {}", points.front().config);
    return to_svg(plot);
}

}  // namespace palpate
