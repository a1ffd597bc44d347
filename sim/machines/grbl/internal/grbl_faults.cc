#include "sim/machines/grbl/internal/grbl_faults.h"

#include <algorithm>

#include "planner/random.h"

namespace palpate {

GrblFaults::GrblFaults(const VirtualGrblOptions& options)
    : script_(options.faults), spurious_rate_(options.spurious_rate), bounce_rate_(options.bounce_rate), random_(options.seed) {}

std::vector<VirtualFault> GrblFaults::take(VirtualFault::When when, double at) {
    std::vector<VirtualFault> due;
    std::vector<VirtualFault> rest;
    for (const VirtualFault& fault : script_) (fault.when == when && fault.at <= at ? due : rest).push_back(fault);
    script_ = rest;
    return due;
}

std::optional<Seconds> GrblFaults::next_time() const {
    std::optional<Seconds> next;
    for (const VirtualFault& fault : script_) {
        if (fault.when == VirtualFault::When::time) next = next ? std::min(*next, Seconds(fault.at)) : Seconds(fault.at);
    }
    return next;
}

double GrblFaults::draw() { return uniform(random_); }

std::optional<double> GrblFaults::draw_spurious() {
    const bool happens = draw() < spurious_rate_;
    const double share = draw();
    return happens ? std::optional(share) : std::nullopt;
}

bool GrblFaults::draw_bounce() { return draw() < bounce_rate_; }

}  // namespace palpate
