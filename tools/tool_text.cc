#include "tools/tool_text.h"

#include <fmt/format.h>

#include <array>
#include <variant>
#include <vector>

#include "planner/number_text.h"

namespace palpate {
namespace {

std::string direction_text(const Vector& v) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", v.x(), v.y(), v.z()); }

std::string text_of(const Fixture& fixture) {
    if (const auto* table = std::get_if<Table>(&fixture)) return fmt::format("table at z = {:.6g} mm", table->z);
    if (const auto* box = std::get_if<Box>(&fixture)) return fmt::format("box {} to {}", point_text(box->min), point_text(box->max));
    const auto& half = std::get<HalfSpace>(fixture);
    return fmt::format("all behind {} as seen along {}", point_text(half.point), direction_text(half.normal));
}

}  // namespace

std::string describe(const ToolShape& tool) {
    std::string text = fmt::format("ball of {:.6g} mm", tool.ball_diameter);
    if (!tool.stylus) return text + " that floats";
    text += fmt::format(", stylus of {:.6g} x {:.6g} mm towards {}", tool.stylus->diameter, tool.stylus->length, direction_text(tool.axis));
    if (tool.holder) text += fmt::format(", holder of {:.6g} x {:.6g} mm", tool.holder->diameter, tool.holder->length);
    return text;
}

std::string describe(const Fixtures& fixtures) {
    if (fixtures.solids.empty()) return "none";
    std::vector<std::string> texts;
    for (const Fixture& fixture : fixtures.solids) texts.push_back(text_of(fixture));
    std::string text = fmt::format("{}", fmt::join(texts, ", "));
    if (fixtures.clearance) text += fmt::format("; the tool keeps {:.6g} mm off them", *fixtures.clearance);
    return text + (fixtures.assume_clear ? "; nothing but the part stands on them" : "; what stands on them is looked for");
}

std::string describe_area(const Surroundings& surroundings) {
    const Box box = surroundings.bounds();
    const Vector size = box.max - box.min;
    std::string text = fmt::format("{:.6g} x {:.6g} x {:.6g} mm of the ball's centre", size.x(), size.y(), size.z());
    if (const auto* prism = std::get_if<Prism>(&*surroundings.area())) {
        text += fmt::format(", in a polygon of {} corners and {:.6g} mm2", prism->corners.size(), size_of(*surroundings.area()));
    }
    constexpr std::array<std::array<const char*, 2>, 3> kNames{{{"-x", "+x"}, {"-y", "+y"}, {"below", "above"}}};
    std::string ways;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (const std::size_t end : {0U, 1U}) {
            if (surroundings.faces().is_open.at(axis).at(end))
                ways += fmt::format("{}{}", ways.empty() ? "" : ", ", kNames.at(axis).at(end));
        }
    }
    return fmt::format("{}; the tool comes from {}", text, ways);
}

}  // namespace palpate
