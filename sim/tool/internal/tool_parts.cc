#include "sim/tool/internal/tool_parts.h"

#include <algorithm>
#include <stdexcept>

namespace palpate {

std::vector<ToolPart> parts_of(const ToolShape& tool) {
    if (!(tool.ball_diameter > 0)) throw std::invalid_argument("the tool's ball needs a diameter");
    if (tool.stylus && tool.stylus->diameter > tool.ball_diameter) throw std::invalid_argument("the stylus is thicker than its ball");
    std::vector<ToolPart> parts{{ToolContact::Part::ball, Vector::Zero(), {Vector::Zero(), tool.ball_diameter / 2}}};
    double end = 0;
    if (tool.stylus) {
        // From the ball's centre: its lower end is within the ball.
        const double radius = tool.stylus->diameter / 2;
        end = tool.stylus->length;
        parts.push_back({ToolContact::Part::stylus, Vector::Zero(), {std::max(0.0, end - radius) * tool.axis, radius}});
    }
    if (tool.holder) {
        const double radius = tool.holder->diameter / 2;
        parts.push_back(
            {ToolContact::Part::holder, (end + radius) * tool.axis, {std::max(0.0, tool.holder->length - 2 * radius) * tool.axis, radius}});
    }
    return parts;
}

}  // namespace palpate
