#include "devices/grbl/grbl_report.h"

#include <fmt/format.h>

#include <array>
#include <limits>

#include "devices/motion_model.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

using namespace grbl::setting;

constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"};

class Reporter {
public:
    explicit Reporter(const grbl::Identity& identity) : identity_(identity) {}

    // A setting, with what is wrong about its value if anything is. Left out where the firmware does not have it.
    template <typename Check>
    void add(int number, const std::string& meaning, const std::string& unit, const Check& check) {
        const auto value = identity_.number(number);
        if (!value) return;
        settings_.push_back({fmt::format("${} {}", number, meaning), fmt::format("{:g}{}", *value, unit), check(*value)});
    }
    [[nodiscard]] std::vector<MachineSetting> take() { return std::move(settings_); }

private:
    const grbl::Identity& identity_;
    std::vector<MachineSetting> settings_;
};

std::string nothing_wrong(double /*value*/) { return {}; }

void add_axes(Reporter& reporter, const GrblOptions& options) {
    const MotionModel& k = options.motion;
    const double fastest = std::max({k.feeds.travel_mm_per_s, k.feeds.probe_mm_per_s, k.feeds.touch_mm_per_s});
    for (int axis = 0; axis < 3; ++axis) {
        const std::string name = kAxes.at(static_cast<std::size_t>(axis));
        reporter.add(kStepsPerMm + axis, fmt::format("steps per mm, {}", name), "", [&](double steps) {
            if (!(steps > 0 && 1 / steps > k.resolution_mm)) return std::string();
            return fmt::format("a step is {0:g} mm: say machine.resolution: {0:g} or more", 1 / steps);
        });
        reporter.add(kMaxRate + axis, fmt::format("greatest rate, {}", name), " mm/min", [&](double rate) {
            return rate < fastest * kSecondsPerMinute ? "slower than machine.feeds: moves take longer than reckoned" : "";
        });
        reporter.add(kAcceleration + axis, fmt::format("acceleration, {}", name), " mm/s²", [&](double acceleration) {
            return acceleration < k.acceleration_mm_per_s2 ? "less than machine.acceleration, so the tool needs longer to stop than was "
                                                             "checked: lower machine.acceleration to it"
                                                           : "";
        });
        reporter.add(kMaxTravel + axis, fmt::format("travel, {}", name), " mm", nothing_wrong);
    }
}

// Grbl homes to the end of every axis and calls that 0; its travel lies on the other side, which is negative unless $23 says otherwise
// in a build that sets the origin there.
std::optional<Box> reach_of(const grbl::Identity& identity, const Point& origin) {
    Box box;
    for (int axis = 0; axis < 3; ++axis) {
        const auto travel = identity.number(kMaxTravel + axis);
        if (!travel || *travel <= 0) return std::nullopt;
        box.min[axis] = -*travel;
        box.max[axis] = 0;
    }
    return Box{box.min - origin, box.max - origin};
}

// What a session would refuse, and what it would set itself.
void add_conditions(grbl::Controller& controller, std::vector<MachineSetting>& settings) {
    const bool is_laser = controller.identity().number(kLaserMode) == 1;
    const std::string running = controller.active_accessories() + controller.conditions().running;
    const auto runs = [&](char letter) { return running.find(letter) != std::string::npos; };
    const auto add = [&](const std::string& name, bool is_on, const std::string& end) {
        settings.push_back({name, is_on ? "on" : "off", is_on ? fmt::format("nothing moves while it is on: end it with {}", end) : ""});
    };
    if (is_laser) settings.push_back({"$32 laser mode", "1: M3 and M4 mean the laser", ""});
    add(is_laser ? "laser" : "spindle", runs('S') || runs('C'), "M5");
    add("coolant", runs('F') || runs('M'), "M9");
    const auto feed_override = controller.feed_override();
    settings.push_back(
        {"feed override", feed_override ? fmt::format("{} %", *feed_override) : "not reported",
         feed_override.value_or(100) > 100 ? "moves are faster than they are told: set it to 100 %, as a session will" : ""});
}

std::string state_text(const grbl::Place& place, Homing homing) {
    std::string text = place.state;
    if (place.state == "Alarm") {
        text += homing == Homing::run    ? ": locked; it will be homed"
                : homing == Homing::skip ? ": locked; it will be unlocked, and its position taken for right"
                                         : ": locked; home it first";
    }
    if (place.homed) text += *place.homed ? ", homed" : ", not homed";
    return text;
}

}  // namespace

MachineReport report_on(GrblDevice& device) {
    grbl::Controller& controller = device.controller();
    const grbl::Identity& identity = controller.identity();
    const grbl::Place place = controller.place();
    MachineReport report;
    report.identity = fmt::format("{} on {}", identity.version, controller.link().name());
    report.state = state_text(place, device.options().homing);
    report.needs_homing = place.state == "Alarm" || place.homed == false;
    report.position = place.position - device.options().origin;
    report.reach = reach_of(identity, device.options().origin);

    Reporter reporter(identity);
    reporter.add(kInvertProbe, "probe input inverted", "", nothing_wrong);
    reporter.add(kReportMask, "what reports hold", "", nothing_wrong);
    reporter.add(kReportInches, "reports in inches", "", [](double inches) {
        return inches == 1 ? "inches have a coarser last digit: say $13=0, or machine.resolution: 0.00254 or more" : "";
    });
    reporter.add(kSoftLimits, "soft limits (ours are machine.limits)", "", nothing_wrong);
    reporter.add(kHardLimits, "hard limits", "", nothing_wrong);
    reporter.add(kHomingCycle, "homing", "", [&](double on) {
        return on == 0 && device.options().homing != Homing::skip
                   ? "off, so the machine cannot be homed: switch it on, or say machine.homing: skip and set its position by hand"
                   : "";
    });
    reporter.add(kHomingDirections, "directions of homing", "", nothing_wrong);
    add_axes(reporter, device.options());
    report.settings = reporter.take();
    const bool is_refused = device.options().homing == Homing::require && report.needs_homing;
    report.settings.push_back({"ready", is_refused ? "no" : "yes", is_refused ? "home it, or say machine.homing: run or skip" : ""});
    report.settings.push_back({"work offset (WCO)", point_text(controller.work_offset()), ""});
    add_conditions(controller, report.settings);
    report.settings.push_back({"probe",
                               place.probe_unplugged ? "unplugged"
                               : place.probe_closed  ? "closed"
                                                     : "open",
                               place.probe_unplugged ? "plug it in"
                               : place.probe_closed  ? "free it; if it touches nothing, is its input inverted ($6)?"
                                                     : ""});
    return report;
}

}  // namespace palpate
