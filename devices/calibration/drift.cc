#include "devices/calibration/drift.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

// Of the normals' singular values, the least to the largest: errors of touches count ten times at the most.
constexpr double kLeastSpread = 0.1;

}  // namespace

Vector shift_of(const std::vector<DatumOffset>& offsets) {
    const SeenShift seen = seen_shift_of(offsets);
    if (seen.directions == 3) return seen.shift;
    throw DriftError("the datum touches leave a direction open: touch three places whose normals are independent");
}

SeenShift seen_shift_of(const std::vector<DatumOffset>& offsets) {
    if (offsets.empty()) return {};
    const auto count = static_cast<Eigen::Index>(offsets.size());
    Eigen::MatrixXd normals(count, 3);
    Eigen::VectorXd sizes(count);
    for (Eigen::Index k = 0; k < count; ++k) {
        const DatumOffset& offset = offsets[static_cast<std::size_t>(k)];
        normals.row(k) = offset.normal;
        sizes[k] = offset.offset_mm;
    }
    if (!normals.allFinite() || !sizes.allFinite()) throw DriftError("a datum touch has a number that is not finite");
    // Of all shifts that fit best the shortest.
    Eigen::JacobiSVD<Eigen::MatrixXd> svd(normals, Eigen::ComputeThinU | Eigen::ComputeThinV);
    svd.setThreshold(kLeastSpread);
    return {svd.solve(sizes), static_cast<int>(svd.rank())};
}

void require_steady(const std::vector<DriftReading>& readings, double most_jump_mm) {
    if (!(most_jump_mm > 0)) throw DriftError(fmt::format("the limit of a jump is {} mm, it has to be positive", most_jump_mm));
    for (std::size_t k = 0; k < readings.size(); ++k) {
        const DriftReading& now = readings[k];
        if (!std::isfinite(now.at) || !now.shift.allFinite()) throw DriftError(fmt::format("reading {} of the drift is not finite", k + 1));
        if (k == 0) continue;
        const DriftReading& before = readings[k - 1];
        if (!(before.at < now.at)) {
            throw DriftError(
                fmt::format("readings {} and {} of the drift are not in order: {} comes before {}", k, k + 1, before.at, now.at));
        }
        const double jump = (now.shift - before.shift).norm();
        if (jump <= most_jump_mm) continue;
        throw DriftError(
            fmt::format("the datum jumped by {:.4f} mm between {} and {}, more than {:.4f} mm: the part, the sphere or the machine moved. "
                        "What was touched between cannot be corrected; fasten it, and touch that again",
                        jump, before.at, now.at, most_jump_mm));
    }
}

Vector drift_at(const std::vector<DriftReading>& readings, double at) {
    if (readings.empty()) return Vector::Zero();
    const auto next = std::ranges::upper_bound(readings, at, {}, &DriftReading::at);
    if (next == readings.begin()) return next->shift;
    if (next == readings.end()) return readings.back().shift;
    const DriftReading& before = *(next - 1);
    const double share = (at - before.at) / (next->at - before.at);
    return before.shift + share * (next->shift - before.shift);
}

}  // namespace palpate
