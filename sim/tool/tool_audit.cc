#include "sim/tool/tool_audit.h"

#include <algorithm>

namespace palpate {

void ToolAudit::record(const Segment& move, bool touched) {
    ++moves_;
    const ToolDepth depth = depths_.along(move);
    into_object_ += depth.object > tolerance_ ? 1 : 0;
    into_fixtures_ += depth.fixture > tolerance_ ? 1 : 0;
    unsafe_ += depth.deepest() > tolerance_ ? 1 : 0;
    deepest_ = {std::max(deepest_.object, depth.object), std::max(deepest_.fixture, depth.fixture)};
    if (!touched) return;
    if (const auto contact = depths_.touching(move.target, kTolerance_mm)) {
        ++touches_.at(static_cast<std::size_t>(contact->part)).at(static_cast<std::size_t>(contact->met));
    }
}

}  // namespace palpate
