#include "devices/external/external_machine.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "planner/number_text.h"

namespace palpate {

ExternalMachine::ExternalMachine(std::unique_ptr<ByteStream> stream, const ExternalOptions& options, StopToken stop)
    : stream_(std::move(stream)), device_(*stream_, clock_, options, std::move(stop)) {}

MachineReport ExternalMachine::report() {
    const ExternalHello& hello = device_.hello();
    const ExternalState state = device_.state();
    const MotionModel& motion = device_.options().motion;
    const Point& origin = device_.options().origin;
    MachineReport report;
    report.identity = fmt::format("{} on {}", hello.name, device_.name());
    report.state = !state.fault.empty() ? "fault" : !state.is_homed ? "not homed" : state.is_moving ? "moving" : "standing";
    report.needs_homing = !state.is_homed;
    report.position = state.position - origin;
    report.reach = Box{hello.limits.min - origin, hello.limits.max - origin};
    const auto add = [&](const char* name, std::string value, bool is_good, const std::string& problem) {
        report.settings.push_back({name, std::move(value), is_good ? "" : problem});
    };
    add("homed", state.is_homed ? "yes" : "no", state.is_homed,
        fmt::format("nobody knows where the tool is: home it{}", hello.homes ? ", or say machine.homing: run" : " by its own means"));
    add("fault", state.fault.empty() ? "none" : state.fault, state.fault.empty(), "clear its cause");
    add("probe", state.is_probe_closed ? "closed" : "open", !state.is_probe_closed, "free it, or look at its lead");
    const double fastest = std::max({motion.feeds.travel_mm_per_s, motion.feeds.probe_mm_per_s, motion.feeds.touch_mm_per_s});
    add("greatest feed", number_text(hello.feed_mm_per_s, " mm/s"), hello.feed_mm_per_s >= fastest,
        "slower than machine.feeds: moves go at that, and take longer than reckoned");
    add("greatest acceleration", number_text(hello.acceleration_mm_per_s2, " mm/s²"),
        hello.acceleration_mm_per_s2 >= motion.acceleration_mm_per_s2,
        "less than machine.acceleration, so the tool needs longer to stop than was checked: lower machine.acceleration to it");
    add("resolution", number_text(hello.resolution_mm, " mm"), hello.resolution_mm <= motion.resolution_mm,
        fmt::format("coarser than machine.resolution: say {} or more there", number_text(hello.resolution_mm)));
    if (hello.latch_time > Seconds(0)) {
        const double late_mm = hello.latch_time.count() * motion.feeds.of(device_.options().touch_pace);
        add("touch seen within",
            fmt::format("{}, {} of the way", number_text(1e3 * hello.latch_time.count(), " ms"), number_text(late_mm, " mm")),
            late_mm <= device_.options().touch_error_mm,
            "more than touches are said to be off by: raise machine.noise to it, or lower machine.feeds");
    }
    return report;
}

bool ExternalMachine::is_position_trusted() {
    const ExternalState state = device_.state();
    return state.is_homed && state.fault.empty();
}

}  // namespace palpate
