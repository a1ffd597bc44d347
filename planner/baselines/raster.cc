#include <array>
#include <vector>

#include "planner/baselines/baselines.h"
#include "planner/baselines/internal/meter.h"

namespace palpate {

BaselineResult probe_raster(SurfaceOracle& oracle, const Surroundings& surroundings, std::uint64_t probes) {
    BaselineResult result;
    const double radius = surroundings.region().radius();
    const Point low = surroundings.region().center() - Point::Constant(radius);
    const double top = surroundings.region().center().z() + radius;
    const auto at = [&](std::uint64_t i, std::uint64_t j, std::uint64_t lines) {
        const double step = 2 * radius / static_cast<double>(lines);
        return Point(low.x() + (static_cast<double>(i) + 0.5) * step, low.y() + (static_cast<double>(j) + 0.5) * step, top);
    };
    const auto meets = [&](const Point& p) { return surroundings.unknown_part(p, -Vector::UnitZ()).has_value(); };
    // The finest grid that the number of probes allows.
    std::uint64_t lines = 0;
    for (std::uint64_t count = 0; count <= probes; ++lines) {
        count = 0;
        for (std::uint64_t i = 0; i <= lines; ++i) {
            for (std::uint64_t j = 0; j <= lines; ++j) count += meets(at(i, j, lines + 1)) ? 1 : 0;
        }
        if (count > probes) break;
    }
    if (lines == 0) return result;
    Meter meter(oracle);
    constexpr std::uint32_t kNone = ~std::uint32_t{0};
    std::vector<std::uint32_t> touched(lines * lines, kNone);
    for (std::uint64_t i = 0; i < lines; ++i) {
        for (std::uint64_t k = 0; k < lines; ++k) {
            const std::uint64_t j = i % 2 == 0 ? k : lines - 1 - k;
            const Point start = at(i, j, lines);
            if (!meets(start)) continue;
            if (meter.at() != start) meter.travel({start});
            const auto contact = meter.probe({start.x(), start.y(), low.z()});
            if (contact) {
                touched[i * lines + j] = static_cast<std::uint32_t>(result.mesh.points.size());
                result.mesh.points.push_back(*contact);
            }
            meter.travel({start});
        }
    }
    for (std::uint64_t i = 0; i + 1 < lines; ++i) {
        for (std::uint64_t j = 0; j + 1 < lines; ++j) {
            const std::array<std::uint32_t, 4> corners{touched[i * lines + j], touched[(i + 1) * lines + j],
                                                       touched[(i + 1) * lines + j + 1], touched[i * lines + j + 1]};
            std::vector<std::uint32_t> known;
            for (const std::uint32_t corner : corners) {
                if (corner != kNone) known.push_back(corner);
            }
            if (known.size() >= 3) result.mesh.triangles.push_back({known[0], known[1], known[2]});
            if (known.size() == 4) result.mesh.triangles.push_back({known[0], known[2], known[3]});
        }
    }
    result.cost = meter.cost();
    return result;
}

}  // namespace palpate
