#include "tools/anytime.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "config/strategy_names.h"
#include "devices/device_oracle.h"
#include "planner/baselines.h"
#include "sim/simulated_device.h"
#include "tools/view/line_plot.h"

namespace palpate {
namespace {

constexpr double kStepsPerDecade = 5.0;
constexpr std::uint64_t kFewestProbes = 50;
constexpr std::uint64_t kMostBaselineProbes = 100'000;
constexpr const char* kRaster = "z-raster";
constexpr const char* kRandomRays = "random rays";

// Probes to stop after, on the way to `last`.
std::vector<std::uint64_t> budgets(std::uint64_t last) {
    std::vector<std::uint64_t> all;
    for (int k = 0;; ++k) {
        const auto budget =
            static_cast<std::uint64_t>(std::llround(static_cast<double>(kFewestProbes) * std::pow(10.0, k / kStepsPerDecade)));
        if (budget >= last) break;
        all.push_back(budget);
    }
    return all;
}

AnytimePoint point_of(const std::string& name, const Strategy& strategy, const Simulation& run) {
    const Result& r = run.result;
    return {name,
            to_string(strategy),
            r.cost.probes(),
            r.cost.displacement(),
            r.topology.facets,
            run.truth->hausdorff,
            run.truth->mean_distance,
            run.unsafe_moves};
}

template <typename Probe>
AnytimePoint measure_baseline(const std::string& name, const char* method, const SessionConfig& config, const Scene& scene,
                              const Probe& probe) {
    const Region& workspace = scene.workspace.region();
    SimulatedDevice device(scene.object, workspace.nearest_boundary(workspace.center() + 2 * workspace.radius() * Vector::UnitZ()));
    DeviceOracle oracle(device);
    const BaselineResult run = probe(oracle, workspace);
    const Truth truth = measure_truth(scene.object, run.mesh, TruthSampling{}, config.probing.random_seed);
    return {name,
            method,
            run.cost.probes(),
            run.cost.displacement(),
            run.mesh.triangles.size(),
            truth.hausdorff,
            truth.mean_distance,
            device.unsafe_moves()};
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
    const Budget given = config.probing.budget;
    for (const Strategy& strategy : strategies) {
        config.probing.strategy = strategy;
        config.probing.budget = given;
        const AnytimePoint end = point_of(name, strategy, simulate(config, scene, {}));
        most = std::max(most, end.probes);
        for (const std::uint64_t budget : budgets(end.probes)) {
            config.probing.budget.probes = budget;
            add(point_of(name, strategy, simulate(config, scene, {})));
        }
        add(end);
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
    return points;
}

std::string anytime_csv(const std::vector<AnytimePoint>& points) {
    std::string text = "config,method,probes,displacement,facets,hausdorff,mean_distance,unsafe_moves\n";
    for (const AnytimePoint& p : points) {
        text += fmt::format("{},{},{},{:.10g},{},{:.10g},{:.10g},{}\n", p.config, p.method, p.probes, p.displacement, p.facets, p.hausdorff,
                            p.mean_distance, p.unsafe_moves);
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
    if (!points.empty()) plot.title = fmt::format("Error before the end: {}", points.front().config);
    return to_svg(plot);
}

}  // namespace palpate
