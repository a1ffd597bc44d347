#include "tools/table_setup.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "devices/errors.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

// No table is mounted so badly; a part or a clamp among the three places shows as more, unless it is very flat.
constexpr double kMostTilt = 5.0;  // degrees
// The three places have to be so far apart that the plane between them is not the touch error's.
constexpr double kLeastHeight = 10.0;  // mm, of the triangle
// Digits of what is written, mm.
constexpr double kFine = 0.001;
constexpr double kCoarse = 0.1;

double rounded(double value, double unit) { return std::round(value / unit) / std::round(1 / unit); }
double rounded_down(double value, double unit) { return std::floor(value / unit + 1e-6) / std::round(1 / unit); }
double rounded_up(double value, double unit) { return -rounded_down(-value, unit); }
Point rounded(const Point& p, double unit) { return {rounded(p.x(), unit), rounded(p.y(), unit), rounded(p.z(), unit)}; }

std::string text(const Point& p) {
    return fmt::format("[{}, {}, {}]", number_text(p.x() + 0.0), number_text(p.y() + 0.0), number_text(p.z() + 0.0));
}
std::string text(const Box& box) { return fmt::format("{{min: {}, max: {}}}", text(box.min), text(box.max)); }
std::string text(const Segment& ray) { return fmt::format("{{from: {}, to: {}}}", text(ray.source), text(ray.target)); }
std::string text(const Fixture& fixture) {
    if (const auto* table = std::get_if<Table>(&fixture)) return fmt::format("{{table: {{z: {}}}}}", number_text(table->z + 0.0));
    if (const auto* box = std::get_if<Box>(&fixture)) return fmt::format("{{box: {}}}", text(*box));
    const auto& half = std::get<HalfSpace>(fixture);
    return fmt::format("{{half_space: {{point: {}, normal: {}}}}}", text(half.point), text(half.normal));
}

// What lies below, as the touched table does.
bool is_table(const Fixture& fixture) {
    if (std::holds_alternative<Table>(fixture)) return true;
    const auto* half = std::get_if<HalfSpace>(&fixture);
    constexpr double kUpwards = 0.7;
    return half != nullptr && half->normal.z() > kUpwards;
}

template <class Each>
double extreme_height(const TablePlane& table, const Box& box, Each choose) {
    double height = table.height(box.min.x(), box.min.y());
    for (const double x : {box.min.x(), box.max.x()}) {
        for (const double y : {box.min.y(), box.max.y()}) height = choose(height, table.height(x, y));
    }
    return height;
}
double lowest(const TablePlane& table, const Box& box) {
    return extreme_height(table, box, [](double a, double b) { return std::min(a, b); });
}

// mm: how far beside a part of that height its touches may be: by the ball, and by the holder where it comes down to the part.
double touching_width(const SessionConfig& config, double part_height, double radius) {
    const ToolShape& tool = *config.tool;
    if (!tool.holder || !tool.stylus || part_height < tool.stylus->length - tool.holder->diameter / 2) return radius;
    return std::max(radius, tool.holder->diameter / 2);
}

// From outside of the workspace, along the touch, and some way into the part, not into the table.
Segment ray_of(const PartTouch& touch, const Box& workspace, const TablePlane& table, double epsilon, double radius) {
    Point from = touch.position;
    int axis = 0;
    touch.approach.cwiseAbs().maxCoeff(&axis);
    from[axis] = touch.approach[axis] > 0 ? workspace.min[axis] - epsilon : workspace.max[axis] + epsilon;
    Point to = touch.position + radius * touch.approach;
    to.z() = std::max(to.z(), (touch.position.z() + table.touched_height(to.x(), to.y(), radius)) / 2);
    return {rounded(from, kFine), rounded(to, kFine)};
}

}  // namespace

double TablePlane::height(double x, double y) const {
    return point.z() - (normal.x() * (x - point.x()) + normal.y() * (y - point.y())) / normal.z();
}

double TablePlane::tilt_degrees() const { return std::acos(std::min(1.0, normal.z())) * 180 / std::numbers::pi; }

double TablePlane::rise_over(const Box& box) const {
    return extreme_height(*this, box, [](double a, double b) { return std::max(a, b); }) - lowest(*this, box);
}

std::array<Point, 3> default_table_places(const Box& limits) {
    constexpr double kInset = 0.1;
    const auto at = [&](double x, double y) {
        const Vector share(x, y, 1);
        return Point(limits.min + share.cwiseProduct(limits.max - limits.min));
    };
    return {at(kInset, kInset), at(1 - kInset, kInset), at(0.5, 1 - kInset)};
}

TablePlane table_through(const std::array<Point, 3>& touched, double radius) {
    const Vector across = (touched[1] - touched[0]).cross(touched[2] - touched[0]);
    const double longest = std::max({(touched[1] - touched[0]).norm(), (touched[2] - touched[1]).norm(), (touched[0] - touched[2]).norm()});
    if (!(across.norm() >= kLeastHeight * longest) || longest == 0.0) {
        throw SetupError(
            fmt::format("--table: the three places are about on a line, or nearer to each other than {} mm: no plane is to be "
                        "told from them; give others",
                        kLeastHeight));
    }
    TablePlane table;
    table.normal = (across.z() < 0 ? Vector(-across) : across).normalized();
    table.point = (touched[0] + touched[1] + touched[2]) / 3 - radius * table.normal;
    if (table.tilt_degrees() > kMostTilt) {
        throw SetupError(
            fmt::format("the plane through {}, {} and {} is tilted by {:.1f} degrees: that is no table; one of them was "
                        "touched on something else. Give --table other places",
                        point_text(touched[0]), point_text(touched[1]), point_text(touched[2]), table.tilt_degrees()));
    }
    return table;
}

TableSetup propose_setup(const SessionConfig& config, const TablePlane& table, const Box& part, const std::vector<PartTouch>& touches,
                         double radius, double margin) {
    TableSetup setup;
    const double beside = touching_width(config, part.max.z() - part.min.z(), radius) + margin;
    Box& workspace = setup.workspace;
    for (int axis = 0; axis < 2; ++axis) {
        workspace.min[axis] = rounded_down(part.min[axis] - beside, kCoarse);
        workspace.max[axis] = rounded_up(part.max[axis] + beside, kCoarse);
    }
    workspace.min.z() = rounded_down(lowest(table, workspace), kFine);
    workspace.max.z() = rounded_up(part.max.z() + radius + margin, kCoarse);
    setup.is_tilted = table.rise_over(workspace) > config.machine->touch_error();
    const Point middle = workspace.center();
    const Point below(middle.x(), middle.y(), table.height(middle.x(), middle.y()));
    if (setup.is_tilted) {
        setup.solids.emplace_back(HalfSpace{rounded(below, kFine), table.normal});
    } else {
        setup.solids.emplace_back(Table{rounded(below.z(), kFine)});
    }
    std::ranges::copy_if(config.fixtures.solids, std::back_inserter(setup.solids), [](const Fixture& f) { return !is_table(f); });
    const double epsilon = config.probing.epsilon;
    std::vector<Point> used;
    for (const PartTouch& touch : touches) {
        if (std::ranges::any_of(used, [&](const Point& p) { return (p - touch.position).norm() <= 2 * epsilon; })) continue;
        used.push_back(touch.position);
        setup.seed_rays.push_back(ray_of(touch, workspace, table, epsilon, radius));
    }
    return setup;
}

std::vector<KeyEdit> edits_of(const TableSetup& setup, const SessionConfig& config) {
    std::vector<std::string> solids;
    for (const Fixture& fixture : setup.solids) solids.push_back(text(fixture));
    std::vector<std::string> rays;
    for (const Segment& ray : setup.seed_rays) rays.push_back(text(ray));
    const auto list = [](const std::vector<std::string>& values) { return fmt::format("[{}]", fmt::join(values, ", ")); };
    // In lines of their own without the braces.
    std::vector<std::string> bare;
    for (const std::string& solid : solids) bare.push_back(solid.substr(1, solid.size() - 2));
    const auto items = [](const std::vector<std::string>& values, const std::string& indent) {
        std::vector<std::string> lines;
        for (const std::string& value : values) lines.push_back(indent + "- " + value);
        return lines;
    };
    const std::string box = text(setup.workspace);
    std::vector<KeyEdit> edits;
    if (std::holds_alternative<Box>(config.workspace)) {
        edits.push_back({"workspace.box", box, {}, "around the part, for the ball's centre"});
        edits.push_back({"workspace.fixtures", list(solids), items(bare, ""), "the first as touched"});
    } else {
        std::vector<std::string> lines{fmt::format("box: {}  # around the part, for the ball's centre", box),
                                       "fixtures:  # the first as touched"};
        std::ranges::copy(items(bare, "  "), std::back_inserter(lines));
        edits.push_back({"workspace", fmt::format("{{box: {}, fixtures: {}}}", box, list(solids)), lines});
    }
    if (!rays.empty()) edits.push_back({"probing.seed_rays", list(rays), items(rays, ""), "each has met the part"});
    return edits;
}

}  // namespace palpate
