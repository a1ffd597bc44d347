#include "sim/tool/tool_audit.h"

#include <algorithm>

namespace palpate {

void ToolAudit::record(const Segment& move, bool touched) {
    const ToolDepth depth = depths_.along(move);
    ++account_.moves;
    account_.moves_into_object += depth.object > tolerance_ ? 1 : 0;
    account_.moves_into_fixtures += depth.fixture > tolerance_ ? 1 : 0;
    account_.unsafe_moves += depth.deepest() > tolerance_ ? 1 : 0;
    account_.deepest = {std::max(account_.deepest.object, depth.object), std::max(account_.deepest.fixture, depth.fixture)};
    if (!touched) return;
    if (const auto contact = depths_.touching(move.target, kTolerance_mm)) ++account_.touches(contact->part, contact->met);
}

}  // namespace palpate
