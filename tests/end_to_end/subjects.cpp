#include "tests/end_to_end/subjects.h"

#include <algorithm>
#include <map>
#include <numbers>

#include "devices/device_oracle.h"
#include "planner/loop/probing_loop.h"

namespace palpate {
namespace {

ShapeSpec placed(ShapeSpec shape, const Point& at, const Vector& degrees = Vector::Zero()) {
    shape.at = at;
    shape.rotate = degrees * std::numbers::pi / 180;
    return shape;
}

std::vector<Subject> make_subjects() {
    const ShapeSpec two{std::vector<ShapeSpec>{placed({SphereSpec{0.5}}, {-0.8, 0.1, 0}),
                                               placed({EllipsoidSpec{{0.6, 0.5, 0.45}}}, {0.7, 0, 0.1}, {10, 20, 30})}};
    return {
        {"sphere", ShapeSpec{SphereSpec{1}}, Region(Ball{Point::Zero(), 1.2}), {0.16, 0.08}, {}},
        {"ellipsoid",
         placed({EllipsoidSpec{{1, 0.8, 0.6}}}, {0.1, 0, 0}, {0, 30, 10}),
         Region(Ball{Point::Zero(), 1.3}),
         {0.16, 0.0575},
         {}},
        {"torus", ShapeSpec{TorusSpec{1, 0.4}}, Region(Ball{Point::Zero(), 1.6}), {0.12, 0.06}, {}},
        {"genus2", ShapeSpec{Genus2Spec{1}}, Region(Box{{-1.5, -0.9, -0.4}, {1.5, 0.9, 0.4}}), {0.08, 0.032}, {}},
        {"rounded_box",
         placed({RoundedBoxSpec{{1.6, 1.2, 0.8}, 0.3}}, {0, 0, 0}, {12, -20, 30}),
         Region(Ball{Point::Zero(), 1.4}),
         {0.15, 0.048},
         {}},
        {"two_components",
         two,
         Region(Ball{Point::Zero(), 1.7}),
         {0.12, 0.05},
         {{{-0.8, 0.1, 1.6}, {-0.8, 0.1, 0}}, {{0.7, 0, 1.6}, {0.7, 0, 0.1}}}},
        {"bunny", MeshSpec{PALPATE_TEST_DATA "/bunny.off", 1.0}, Region(Ball{{0, 4.8, 0}, 7.5}), {0.4, 0.25}, {}},
    };
}

}  // namespace

const std::vector<Subject>& subjects() {
    static const std::vector<Subject> all = make_subjects();
    return all;
}

const Subject& subject(const std::string& name) {
    return *std::find_if(subjects().begin(), subjects().end(), [&](const Subject& s) { return s.name == name; });
}

namespace {

Options options_for(const Subject& subject, double epsilon, const Strategy& strategy, std::optional<double> reach) {
    Options options;
    options.epsilon = epsilon;
    options.strategy = strategy;
    options.seed_rays = subject.seed_rays;
    const std::optional<double> truth = HiddenObject(subject.object).reach();
    if (reach) {
        options.reach = reach;
    } else if (strategy.infer != Strategy::Infer::adaptive && truth && *truth > 0) {
        options.reach = truth;
    }
    return options;
}

}  // namespace

FinishedRun::FinishedRun(const Subject& subject, double epsilon, const Strategy& strategy, const Observer& observer,
                         std::optional<double> reach, const Look& look)
    : FinishedRun(subject, options_for(subject, epsilon, strategy, reach), observer, look) {}

FinishedRun::FinishedRun(const Subject& subject, const Options& options, const Observer& observer, const Look& look,
                         const OracleTraits& traits)
    : object_(std::make_unique<HiddenObject>(subject.object)), workspace_(subject.workspace), options_(options), observer_(observer) {
    if (look) observer_.on_sample = [this, look](const RunView&) { look(run_->space()); };
    observer_.on_inference = [this](const Point& near, const Point& far) {
        ++inferences_;
        if (object_->contains(near) || !object_->contains(far)) ++wrong_inferences_;
    };
    device_ = std::make_unique<SimulatedDevice>(*object_, workspace_.center() + 1.5 * workspace_.radius() * Vector::UnitZ());
    oracle_ = std::make_unique<DeviceOracle>(*device_, traits);
    run_ = std::make_unique<ProbingLoop>(*oracle_, workspace_, options_, observer_);
    run_->execute();
    result_ = run_->result();
}

FinishedRun::~FinishedRun() = default;

const ProbedSpace& FinishedRun::space() const { return run_->space(); }

void expect_right_result(const FinishedRun& run) {
    const Result& r = run.result();
    EXPECT_EQ(r.topology.euler_characteristic, run.object().euler_characteristic());
    EXPECT_EQ(static_cast<int>(r.topology.components), run.object().components());
    EXPECT_EQ(r.topology.boundary_edges, 0U);
    EXPECT_EQ(r.topology.nonmanifold_edges, 0U);
    EXPECT_EQ(r.topology.inconsistent_edges, 0U);
    EXPECT_EQ(r.topology.split_vertices, 0U);
    EXPECT_EQ(r.topology.inward_components, 0U);
    EXPECT_LE(r.max_ball_radius, run.options().epsilon);
    EXPECT_EQ(run.device().unsafe_moves(), 0U);
    EXPECT_NEAR(run.device().distance(), r.cost.displacement(), 1e-9 * r.cost.displacement());
    if (r.certificate.status != Certificate::Status::refuted && run.options().inference() != Strategy::Infer::adaptive) {
        EXPECT_EQ(run.wrong_inferences(), 0U);
    }
    EXPECT_NE(r.certificate.status, Certificate::Status::incomplete);
    EXPECT_TRUE(r.bad_places.empty());
}

void expect_sparse(const FinishedRun& run) {
    const double epsilon = run.options().epsilon;
    std::map<std::array<int, 3>, std::vector<Point>> grid;
    for (const Touch& touch : run.result().touches) {
        if (!touch.sample || touch.role == Touch::Role::seed_facet || touch.role == Touch::Role::repair) continue;
        std::array<int, 3> cell{};
        for (int k = 0; k < 3; ++k) cell[static_cast<std::size_t>(k)] = static_cast<int>(std::floor(touch.position[k] / epsilon));
        grid[cell].push_back(touch.position);
    }
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& [cell, points] : grid) {
        for (int k = 0; k < 27; ++k) {
            const auto other = grid.find({cell[0] + k % 3 - 1, cell[1] + k / 3 % 3 - 1, cell[2] + k / 9 - 1});
            if (other == grid.end()) continue;
            for (const Point& p : points) {
                for (const Point& q : other->second) {
                    if (&p != &q) nearest = std::min(nearest, (p - q).norm());
                }
            }
        }
    }
    EXPECT_GT(nearest, epsilon * (1 - 1e-9));
}

void expect_true_records(const FinishedRun& run) {
    const MaintainedDelaunay& state = run.space().delaunay();
    const double tolerance = 1e-9 * run.object().scale();
    const bool exhaustive = run.options().strategy.explore == Strategy::Explore::exhaustive;
    const bool guesses = run.options().inference() == Strategy::Infer::adaptive;  // its inferences are a heuristic's
    std::size_t checked = 0;
    std::size_t wrong = 0;
    for (CellId cell = 0; cell < state.cell_slots(); ++cell) {
        if (!state.is_live(cell) || !state.is_free(cell)) continue;
        for (int i = 0; i < 4; ++i) {
            const DirectedEdge e{cell, i};
            const auto span = state.span(e);
            if (!span) continue;
            const EdgeState known = state.recorded_state(e);
            ++checked;
            const std::vector<Point> crossings = run.object().crossings({span->start_point(), span->end_point()});
            bool good = !run.object().contains(span->start_point());
            if (known == EdgeState::unknown) good &= !exhaustive;
            if (known == EdgeState::clear) good &= crossings.empty();
            if (known == EdgeState::crossing) {
                const Crossing& c = state.crossing(e);
                const auto is_near = [&](const Point& x) { return (x - c.near).norm() < tolerance; };
                if (c.inferred && guesses) {
                    continue;
                } else if (c.inferred) {
                    good &= !run.object().contains(c.near) && run.object().contains(c.far);
                } else if (c.from_vertex) {
                    good &= !crossings.empty() && is_near(crossings.front());
                } else {
                    good &= std::any_of(crossings.begin(), crossings.end(), is_near);
                }
            }
            if (good || ++wrong > 5) continue;
            ADD_FAILURE() << "cell " << cell << ", facet " << i << ": state " << static_cast<int>(known) << ", " << crossings.size()
                          << " crossings between " << span->start_point().transpose() << " and " << span->end_point().transpose();
        }
    }
    EXPECT_EQ(wrong, 0U) << "of " << checked;
    EXPECT_GT(2 * checked, run.result().samples) << "too few ends of edges are free to see anything";
}

std::string strategy_name(const Strategy& strategy) {
    if (strategy == Strategy{}) return "default";
    if (strategy.infer == Strategy::Infer::adaptive) return "adaptive";
    return std::string(strategy.refine == Strategy::Refine::eager ? "eager" : "exhaustive") + "_" +
           (strategy.explore == Strategy::Explore::closure ? "closure" : "exhaustive");
}

std::vector<Strategy> all_strategies() {
    std::vector<Strategy> all;
    for (const auto refine : {Strategy::Refine::exhaustive, Strategy::Refine::eager}) {
        for (const auto explore : {Strategy::Explore::exhaustive, Strategy::Explore::closure}) {
            all.push_back({refine, explore, Strategy::Infer::none, Strategy::Travel::voronoi});
        }
    }
    all.emplace_back();
    all.push_back(Strategy::adaptive());
    return all;
}

}  // namespace palpate
