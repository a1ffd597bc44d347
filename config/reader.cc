#include "config/reader.h"

#include <array>
#include <fstream>
#include <iterator>
#include <memory>
#include <utility>

#include "config/internal/read_machine.h"
#include "config/internal/read_object.h"
#include "config/internal/section.h"
#include "config/internal/tree.h"
#include "config/strategy_names.h"

namespace palpate {

namespace {

using yaml::kAnyNumber;
using yaml::kPositive;
using yaml::Need;
using yaml::Section;

constexpr std::string_view kMillimetres = "mm";
constexpr std::array<std::string_view, 1> kWorkspaceWords{"auto"};
constexpr yaml::Bounds kFloorBounds{0.0, 1.0, false};
constexpr yaml::Bounds kShareBounds{0.0, 1.0, true};
constexpr yaml::Bounds kMinAngleBounds{0.0, 30.0, true};  // above, refinement need not end (thesis 5.3)

Ball read_ball(Section& section) {
    Ball ball;
    ball.center = section.vector({"center", "centre of the ball", Need::required, kMillimetres}, kAnyNumber);
    ball.radius = section.number({"radius", "radius of the ball", Need::required, kMillimetres}, kPositive);
    return ball;
}

Box read_box(Section& section) {
    Box box;
    box.min = section.vector({"min", "corner with the smallest coordinates", Need::required, kMillimetres}, kAnyNumber);
    box.max = section.vector({"max", "corner with the greatest coordinates; each greater than in `min`", Need::required, kMillimetres},
                             kAnyNumber);
    section.require(box.is_valid(), "max", "is not greater than min in each coordinate; allowed: greater than min in x, y and z (mm)");
    return box;
}

WorkspaceSpec read_workspace(Section& section) {
    WorkspaceSpec workspace;
    const yaml::Key key{
        "workspace",
        "region that contains the object; everything outside it is free. `auto` is for simulations only: around the hidden object",
        Need::optional, "", "auto"};
    section.word_or_mapping(key, kWorkspaceWords, [&](Section& inner) {
        inner.mapping({"ball", "a ball", Need::alternative}, [&](Section& ball) { workspace = read_ball(ball); });
        inner.mapping({"box", "a box along the axes", Need::alternative}, [&](Section& box) { workspace = read_box(box); });
        inner.require_one_alternative();
    });
    return workspace;
}

template <class Option>
Option read_option(Section& section, std::string_view name, std::string_view meaning, Option fallback) {
    return static_cast<Option>(section.word({name, meaning}, strategy_words<Option>(), static_cast<std::size_t>(fallback)));
}

Strategy read_strategy(Section& section) {
    Strategy strategy;
    const yaml::Key key{
        "strategy",
        "how the next probe is chosen; `thesis` is exhaustive, exhaustive, none, voronoi; `adaptive` is the default with that `infer`",
        Need::optional, "", "default"};
    const auto word = section.word_or_mapping(key, strategy_names(), [&](Section& inner) {
        strategy.refine = read_option(
            inner, "refine", "which touches become samples: the worst once every reachable edge is probed, or every bad one at once",
            strategy.refine);
        strategy.explore =
            read_option(inner, "explore", "which edges are probed: all that can be reached, or what closes the surface", strategy.explore);
        strategy.infer = read_option(inner, "infer",
                                     "what is concluded without a probe: nothing; what a bound on the reach proves (without "
                                     "`probing.reach` nothing); or what local bounds suggest that follow the touches, a heuristic",
                                     strategy.infer);
        strategy.travel =
            read_option(inner, "travel",
                        "along which ways the probe moves: along Voronoi edges, or near the surface through all space that is proven free",
                        strategy.travel);
    });
    return word ? named_strategy(*word) : strategy;
}

Segment read_seed_ray(Section& section) {
    Segment ray;
    ray.source = section.vector({"from", "where the ray starts", Need::required, kMillimetres}, kAnyNumber);
    ray.target = section.vector({"to", "where it aims and ends; differs from `from`", Need::required, kMillimetres}, kAnyNumber);
    section.require(ray.source != ray.target, "to", "is the same point as from; allowed: another point (mm)");
    return ray;
}

RegionOfInterest read_region(Section& section) {
    RegionOfInterest region;
    region.box.min = section.vector({"min", "lowest corner of a box", Need::required, kMillimetres}, kAnyNumber);
    region.box.max = section.vector({"max", "its highest corner; a point if it is the same", Need::required, kMillimetres}, kAnyNumber);
    region.size = section.number({"size", "upper bound on ball radii in the box", Need::required, kMillimetres}, kPositive);
    region.slope =
        section.number({"slope", "by how much that grows with the distance from the box, up to epsilon"}, kShareBounds, region.slope);
    section.require((region.box.min.array() <= region.box.max.array()).all(), "max",
                    "lies below min; allowed: no coordinate below that of min (mm)");
    return region;
}

Sizing read_sizing(Section& section) {
    Sizing sizing;
    section.list({"regions", "boxes and points of interest"}, 0, false,
                 [&](Section& region) { sizing.regions.push_back(read_region(region)); });
    sizing.radii_of_curvature =
        section.number({"radii_of_curvature", "upper bound on ball radii, in radii of curvature as the facets around show them; 0: none"},
                       yaml::kNotNegative, sizing.radii_of_curvature);
    sizing.smallest = section.number_or_null(
        {"smallest", "curvature refines no smaller balls; null: twice the refinement floor", Need::optional, kMillimetres}, kPositive);
    return sizing;
}

Budget read_budget(Section& section) {
    Budget budget;
    budget.probes = section.whole_number_or_null({"probes", "the run ends after so many, incomplete; null: any"});
    budget.displacement =
        section.number_or_null({"displacement", "the same for the way of the probe", Need::optional, kMillimetres}, kPositive);
    budget.machine_time = section.number_or_null(
        {"machine_time", "the same for the machine's time, reckoned with machine.feeds", Need::optional, "s"}, kPositive);
    return budget;
}

Options read_probing(Section& section) {
    Options options;
    options.epsilon = section.number(
        {"epsilon", "upper bound on the radius of every surface Delaunay ball of the result", Need::required, kMillimetres}, kPositive);
    options.reach = section.number_or_null(
        {"reach", "lower bound on the reach of the surface that you vouch for; null: none given", Need::optional, kMillimetres}, kPositive);
    options.strategy = read_strategy(section);
    options.standoff = section.number_or_null(
        {"standoff", "how far above the surface a probe starts where that is proven free; null: epsilon", Need::optional, kMillimetres},
        kPositive);
    options.audit = section.number({"audit", "share of the inferred crossings that are touched anyway; at most 300 of them"}, kShareBounds,
                                   options.audit);
    section.list({"seed_rays", "probed first, one per component at least; none: rays from the workspace towards its centre"}, 0, false,
                 [&](Section& ray) { options.seed_rays.push_back(read_seed_ray(ray)); });
    options.refinement_floor = section.number({"refinement_floor",
                                               "where the mesh is not manifold, or a wall is thinner than samples show, balls are refined "
                                               "down to this fraction of epsilon; walls thinner than 1.7 times that stay out of the mesh "
                                               "and are named"},
                                              kFloorBounds, options.refinement_floor);
    section.mapping({"sizing", "where smaller facets are wanted than epsilon asks for", Need::optional, "", "none"},
                    [&](Section& inner) { options.sizing = read_sizing(inner); });
    options.min_angle = section.angle({"min_angle", "triangles with a smaller angle are refined, away from seeds"}, kMinAngleBounds);
    section.mapping({"budget", "what the run may use up", Need::optional, "", "none"},
                    [&](Section& inner) { options.budget = read_budget(inner); });
    return options;
}

SessionConfig read_session(Section& section, const std::filesystem::path& folder) {
    SessionConfig config;
    section.mapping({"object", "the hidden object of a simulation or of a virtual machine", Need::optional, "", "none"},
                    [&](Section& inner) { config.object = yaml::read_object(inner, folder); });
    section.mapping({"machine", "the machine that `palpate probe` drives, and that `palpate vm` imitates", Need::optional, "", "none"},
                    [&](Section& inner) { config.machine = yaml::read_machine(inner, folder); });
    config.workspace = read_workspace(section);
    section.mapping({"probing", "the task", Need::required}, [&](Section& inner) {
        Options options = read_probing(inner);
        config.probing = std::move(options);
    });
    if (config.machine) {
        config.probing.touch_error = config.machine->touch_error();
        config.probing.retract = config.machine->kinematics.retract_mm;
        config.probing.rates = machine_rates(config.machine->kinematics);
    }
    config.probing.random_seed =
        section.whole_number({"random_seed", "the same seed and configuration give the same run"}, config.probing.random_seed);
    section.finish();
    return config;
}

// The text of a file, or one byte more than is allowed of it.
std::string slurp(const std::filesystem::path& file, const yaml::Location& whole) {
    std::error_code ignored;  // what cannot be asked about cannot be opened either
    if (std::filesystem::is_directory(file, ignored)) {
        yaml::fail(whole, "", "is a folder; allowed: a YAML file");
    }
    std::ifstream stream(file, std::ios::binary);
    if (!stream) {
        yaml::fail(whole, "",
                   std::filesystem::exists(file, ignored) ? "cannot be read; allowed: a file that you may read"
                                                          : "does not exist; allowed: a YAML file");
    }
    std::string text(yaml::kMaxBytes + 1, '\0');
    stream.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(stream.gcount()));
    return text;
}

}  // namespace

SessionConfig read_config(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
    return read_config_text(slurp(file, {std::make_shared<const std::string>(file.string()), 0}), file, overrides);
}

SessionConfig read_config_text(const std::string& text, const std::filesystem::path& name, const std::vector<std::string>& overrides) {
    const auto source = std::make_shared<const std::string>(name.string());
    yaml::Value root = yaml::parse(text, {source, 1}, "");
    if (root.kind != yaml::Value::Kind::mapping) {
        yaml::fail(root.where, "", spell(root) + " is not a mapping; allowed: a mapping with at least the key probing");
    }
    for (const std::string& assignment : overrides) {
        yaml::apply_override(root, assignment);
    }
    Section section(root, "");
    return read_session(section, std::filesystem::absolute(name).parent_path());
}

std::vector<KeyDoc> documented_keys() {
    std::vector<KeyDoc> docs;
    Section section(docs, "");
    (void)read_session(section, "/");
    return docs;
}

}  // namespace palpate
