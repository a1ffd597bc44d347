// The baselines see what the planner sees; the tool stays where it may be.
#include "planner/baselines/baselines.h"

#include "devices/device_oracle.h"
#include "planner/topology.h"
#include "sim/truth.h"
#include "tests/end_to_end/subjects.h"

namespace palpate::baselines_test {
namespace {

struct Scene {
    explicit Scene(const std::string& name)
        : object(subject(name).object),
          workspace(subject(name).workspace),
          device(object, workspace.center() + 1.5 * workspace.radius() * Vector::UnitZ()),
          oracle(device) {}
    HiddenObject object;
    Region workspace;
    SimulatedDevice device;
    DeviceOracle oracle;
};

TEST(Baselines, TheRasterSeesWhatLiesOpenToTheSky) {
    Scene scene("sphere");
    const BaselineResult r = probe_raster(scene.oracle, scene.workspace, 2000);
    EXPECT_LE(r.cost.probes(), 2000U);
    EXPECT_GT(r.cost.probes(), 1800U) << "the finest grid that fits";
    EXPECT_EQ(scene.device.unsafe_moves(), 0U);
    EXPECT_NEAR(scene.device.distance(), r.cost.displacement(), 1e-9 * r.cost.displacement());
    ASSERT_GT(r.mesh.points.size(), 500U);
    for (const Point& p : r.mesh.points) {
        EXPECT_NEAR(p.norm(), 1, 1e-9);
        EXPECT_GT(p.z(), 0);
    }
    // The upper half only: the south pole is a radius away from the equator, and more.
    const Truth truth = measure_truth(scene.object, r.mesh, {20'000, 20'000}, 1);
    EXPECT_GT(truth.hausdorff, 1);
    EXPECT_LT(truth.hausdorff, 1.6);
    EXPECT_TRUE(probe_raster(scene.oracle, scene.workspace, 0).mesh.points.empty());
}

TEST(Baselines, RandomRaysComeNearerWithEveryTouch) {
    double before = 10;
    for (const std::uint64_t probes : {100U, 800U, 6400U}) {
        Scene scene("torus");
        const BaselineResult r = probe_random_rays(scene.oracle, scene.workspace, probes, 1);
        EXPECT_EQ(r.cost.probes(), probes);
        EXPECT_EQ(r.mesh.points.size(), r.cost.contact);
        EXPECT_EQ(scene.device.unsafe_moves(), 0U);
        EXPECT_NEAR(scene.device.distance(), r.cost.displacement(), 1e-9 * r.cost.displacement());
        // By Crofton, the share of lines through a ball that meet a set is at most its area over that of the ball; every touched
        // point lies on S.
        for (const Point& p : r.mesh.points) EXPECT_LT(scene.object.distance(p), 1e-9);
        const Truth truth = measure_truth(scene.object, r.mesh, {20'000, 20'000}, 1);
        EXPECT_LT(truth.hausdorff, before / 1.5);
        before = truth.hausdorff;
    }
    EXPECT_LT(before, 0.05);
}

TEST(Baselines, AGaussianProcessFindsASmoothShape) {
    double before = 10;
    for (const std::uint64_t probes : {60U, 240U}) {
        Scene scene("torus");
        const BaselineResult r = probe_gaussian_process(scene.oracle, scene.workspace, probes, 1);
        EXPECT_EQ(r.cost.probes(), probes);
        EXPECT_EQ(scene.device.unsafe_moves(), 0U);
        EXPECT_NEAR(scene.device.distance(), r.cost.displacement(), 1e-9 * r.cost.displacement());
        const SurfaceDistances off = measure_surface(scene.object, r.mesh, 20'000, 1);
        EXPECT_LT(off.max, before / 20);
        before = off.max;
        if (probes < 200) continue;
        const Topology topology = analyse_topology(r.mesh);
        EXPECT_TRUE(topology.is_closed_oriented_manifold());
        EXPECT_EQ(topology.euler_characteristic, 0);
        EXPECT_EQ(topology.components, 1U);
    }
    EXPECT_LT(before, 0.01);
    Scene scene("torus");
    EXPECT_TRUE(probe_gaussian_process(scene.oracle, scene.workspace, 0, 1).mesh.points.empty());
}

// Remembers how far outside ω a guarded move ended or aimed.
class Watched final : public SurfaceOracle {
public:
    Watched(SurfaceOracle& oracle, const Region& workspace) : oracle_(oracle), workspace_(workspace) {}
    OracleTraits traits() const override { return oracle_.traits(); }
    Point position() const override { return oracle_.position(); }
    void travel(std::span<const Point> path, Ground ground) override { oracle_.travel(path, ground); }
    ProbeAnswer probe(const Point& target) override {
        ++probes;
        if (!workspace_.contains(target)) farthest = std::max(farthest, (workspace_.nearest_boundary(target) - target).norm());
        return oracle_.probe(target);
    }
    double farthest = 0.0;
    std::size_t probes = 0;

private:
    SurfaceOracle& oracle_;
    const Region& workspace_;
};

TEST(Tool, NeverAimsOutOfATightWorkspace) {
    const HiddenObject object(ShapeSpec{EllipsoidSpec{{1, 0.8, 0.6}}});
    for (const Region& workspace : {Region(Ball{Point::Zero(), 1.01}), Region(Box{{-1.01, -0.81, -0.61}, {1.01, 0.81, 0.61}})}) {
        for (const Strategy& strategy : {Strategy{}, Strategy::adaptive(), Strategy::thesis()}) {
            SimulatedDevice device(object, {0, 0, 3});
            DeviceOracle oracle(device);
            Watched watched(oracle, workspace);
            Options options;
            options.epsilon = 0.05;
            options.strategy = strategy;
            if (strategy == Strategy{}) options.reach = object.reach();
            const Result r = probe_surface(watched, workspace, options);
            EXPECT_NE(r.certificate.status, Certificate::Status::incomplete);
            EXPECT_EQ(r.topology.euler_characteristic, 2);
            EXPECT_LT(watched.farthest, 1e-9);
            EXPECT_GT(watched.probes, 1000U);
            EXPECT_EQ(device.unsafe_moves(), 0U);
        }
    }
}

}  // namespace
}  // namespace palpate::baselines_test
