#include "tools/tool_text.h"

#include <fmt/format.h>

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

}  // namespace palpate
