// palpate calibrate: a probe is qualified on a reference sphere.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <ostream>

#include "config/editor.h"
#include "config/file_names.h"
#include "config/reader.h"
#include "devices/calibration/probe_qualification.h"
#include "devices/decorators/metered_device.h"
#include "devices/errors.h"
#include "planner/number_text.h"
#include "tools/attended_machine.h"
#include "tools/calibration_file.h"
#include "tools/commands/commands.h"
#include "tools/config_change.h"
#include "tools/machine.h"
#include "tools/session_files.h"
#include "tools/session_plan.h"
#include "tools/terminal/time_left.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

// The sphere as it is said to be, before a probe without faults: where the tool would go is known before it goes there.
class IdealSphere final : public ProbeDevice {
public:
    IdealSphere(const ReferenceSphere& sphere, const ToolShape& tool, double retract_mm, const Point& start)
        : center_(sphere.center), radius_(touched_distance(sphere, tool)), retract_mm_(retract_mm), position_(start) {}

    [[nodiscard]] Point position() const override { return position_; }
    [[nodiscard]] MoveResult guarded_move(const Point& target, Pace /*pace*/) override {
        if (!first_target) first_target = target;
        around = {around.min.cwiseMin(target), around.max.cwiseMax(target)};
        const Vector way = target - position_;
        const double length = way.norm();
        const double nearest = length > 0 ? (center_ - position_).dot(way) / length : 0.0;
        const double half_chord_squared = radius_ * radius_ - (center_ - position_).squaredNorm() + nearest * nearest;
        const double touched = half_chord_squared > 0 ? nearest - std::sqrt(half_chord_squared) : -1.0;
        if (touched < 0 || touched > length) {
            position_ = target;
            return {MoveResult::Outcome::reached, target};
        }
        const Point contact = position_ + touched / length * way;
        position_ += std::max(0.0, touched - retract_mm_) / length * way;
        return {MoveResult::Outcome::contact, contact};
    }
    void stop() override {}

    std::optional<Point> first_target;
    Box around{Point::Constant(std::numeric_limits<double>::infinity()), Point::Constant(-std::numeric_limits<double>::infinity())};

private:
    const Point center_;
    const double radius_;  // mm: of what the ball's centre cannot enter
    const double retract_mm_;
    Point position_;
};

struct Rehearsal {
    Point first_target = Point::Zero();
    Box around;  // all places that the tool goes to
    std::uint64_t touches = 0;
    Seconds time{0};
};

struct Calibration {
    SessionConfig config;
    ReferenceSphere sphere;
    QualificationSettings settings;
    fs::path file;       // of the calibration
    std::string change;  // the configuration that names it; empty: it stays as it is
};

// Throws SetupError if the qualification could not begin with the tool there, or would leave the limits.
Rehearsal rehearse(const Calibration& task, const Point& start) {
    const MachineConfig& machine = *task.config.machine;
    IdealSphere ideal(task.sphere, *task.config.tool, machine.motion.retract_mm, start);
    MeteredDevice metered(ideal, machine.motion);
    MultiTouchDevice touching(metered, machine.touch, machine.motion.retract_mm);
    MeteredDevice counting(touching, machine.motion);
    try {
        (void)touch_sphere(counting, task.sphere, *task.config.tool, task.settings);
    } catch (const QualificationError& error) {
        throw SetupError(fmt::format("{}; nothing has moved", error.what()));
    }
    const Vector error = Vector::Constant(task.settings.margins.center_error_mm);
    const Box around{ideal.around.min - error, ideal.around.max + error};
    if (!machine.limits.contains(around)) {
        throw SetupError(fmt::format(
            "machine.limits: the tool goes around the sphere from {} to {}, but the limits are {} to {}: put the sphere elsewhere, or make "
            "the limits wider",
            point_text(around.min), point_text(around.max), point_text(machine.limits.min), point_text(machine.limits.max)));
    }
    return {ideal.first_target.value_or(start), ideal.around, counting.meter().contacts(), metered.meter().machine_time};
}

// Of what a dead probe would be pressed by; touch_plan.h.
double center_error(const MachineConfig& machine) {
    return std::min(TouchMargins{}.center_error_mm, (machine.motion.overtravel_mm - kMostPretravel_mm) / 2);
}

Calibration task_of(const CalibrateCommand& command) {
    Calibration task;
    task.config = read_config(command.config, command.overrides);
    if (!task.config.machine) throw SetupError(fmt::format("machine: missing; a probe is qualified with {}", connection_keys()));
    if (!task.config.tool) throw SetupError("tool: missing; say which ball is to be qualified: tool: {ball: {diameter: 2}}");
    if (command.sphere.size() != 3) throw SetupError("--sphere: needs three numbers, x,y,z in mm");
    task.sphere = {{command.sphere[0], command.sphere[1], command.sphere[2]}, command.diameter};
    const MachineConfig& machine = *task.config.machine;
    task.settings.margins.center_error_mm = center_error(machine);
    task.settings.overtravel_mm = machine.motion.overtravel_mm;
    task.settings.resolution_mm = machine.motion.resolution_mm;
    task.settings.directions = command.touches;
    task.file = command.output;
    if (task.file.empty()) task.file = fs::path(command.config).replace_extension(".calibration.json");
    return task;
}

bool is_calibration(const fs::path& file) {
    try {
        (void)parse_calibration(read_file(file), file.string());
    } catch (const CalibrationError&) {
        return false;
    }
    return true;
}

// Before anything moves: an older calibration alone gives way, and nothing that is read.
void require_output(const CalibrateCommand& command, Calibration& task) {
    std::vector<fs::path> inputs = inputs_of(task.config, command.config);
    for (const fs::path& input : inputs) {
        std::error_code ignored;
        if (fs::equivalent(input, task.file, ignored) && !is_calibration(input)) {
            throw SetupError(fmt::format("-o {}: is read by this run; choose another file", task.file.string()));
        }
    }
    if (fs::exists(task.file) && !is_calibration(task.file)) {
        throw SetupError(fmt::format("-o {}: is there and no calibration; choose another file", task.file.string()));
    }
    require_writable(task.file);
    if (!command.write) return;
    const fs::path folder = fs::absolute(command.config).parent_path();
    task.change = edited_config(read_file(command.config), command.config,
                                {{"tool.calibration", yaml_text(relative_name(fs::absolute(task.file), folder).string())}});
}

Qualification qualify(ProbeDevice& device, const Calibration& task) {
    MeteredDevice metered(device, task.config.machine->motion);
    try {
        return qualify_probe(metered, task.sphere, *task.config.tool, task.settings);
    } catch (const QualificationError& error) {
        if (metered.meter().moves() == 0) throw SetupError(error.what());
        throw DeviceError(error.what());
    }
}

void tell(const ProbeCalibration& calibration, const Qualification& found, const MachineConfig& machine, std::ostream& out) {
    out << fmt::format("effective radius  {:.4f} mm, of a ball of {:.6g} mm\n", calibration.effective_radius_mm,
                       calibration.tool.ball_diameter)
        << fmt::format("lobing            {:.4f} mm from the earliest to the latest direction\n", lobing_range(calibration.lobing))
        << fmt::format("repeatability     {:.4f} mm\n", calibration.repeatability_mm)
        << fmt::format("form error        {:.4f} mm, {:.4f} mm as touched (ISO 10360-5, {} points)\n", calibration.form_error_mm,
                       calibration.raw_form_error_mm, kIsoTouches)
        << fmt::format("residuals         {:.4f} mm RMS, of {} touches at {:.6g} mm/s\n", calibration.rms_mm, calibration.touches,
                       calibration.feed_mm_per_s)
        << fmt::format("sphere            at {}\n", point_text(found.center))
        << fmt::format("touch error       a session reckons with {:.4f} mm; touches are off by {:.4f} mm before they are corrected{}\n",
                       machine.touch_error(), uncorrected_error(calibration),
                       machine.touch_error() < uncorrected_error(calibration) ? "  <- raise machine.noise" : "");
}

}  // namespace

ExitCode run(const CalibrateCommand& command, Output& output) {
    StopSignals signals;
    Calibration task = task_of(command);
    require_output(command, task);
    const MachineConfig& machine = *task.config.machine;
    GuardedMachine guarded(connect(machine, signals.token()), machine, signals.token(), [&] { signals.pause(); });
    const MachineReport report = guarded.machine().report();
    const bool is_placed = guarded.machine().is_position_trusted() && !machine.homes_first(report);
    // Where homing leads to is not known; how much there is to touch is, and hardly depends on it.
    const Point start = is_placed ? report.position : Point(task.sphere.center + 2 * task.sphere.diameter * task.config.tool->axis);
    const Rehearsal rehearsal = rehearse(task, start);
    const std::string what = fmt::format(
        "{}sphere     {:.6g} mm at {}, which may be {:.2g} mm off; the tool stays between {} and {}\n"
        "effort     {} touches in about {}\n"
        "It will move, guarded and no faster than a probe, straight from where it is to the sphere and around it, which it touches. "
        "Nothing "
        "but the sphere, and its stem below, may be in reach of it.",
        is_placed ? fmt::format("first move to {}\n", point_text(rehearsal.first_target)) : "", task.sphere.diameter,
        point_text(task.sphere.center), task.settings.margins.center_error_mm, point_text(rehearsal.around.min),
        point_text(rehearsal.around.max), rehearsal.touches, duration_text(rehearsal.time));
    let_move(guarded.machine(), report, machine, what, command.yes, output.console, signals);
    (void)rehearse(task, guarded.device().position());
    const Qualification found = qualify(guarded.device(), task);
    signals.release();
    const ProbeCalibration calibration =
        calibration_of(found, task.sphere, *task.config.tool, counting_feed(machine), date_text(std::chrono::system_clock::now()));
    write_file(task.file, to_json(calibration));
    tell(calibration, found, machine, output.results);
    output.results << "written           " << task.file.string() << '\n';
    if (command.write) {
        const fs::path kept = change_config(command.config, task.change);
        output.results << command.config.string() << " names it now; as it was: " << kept.string() << '\n';
    } else {
        const fs::path folder = fs::absolute(command.config).parent_path();
        output.results << fmt::format("add to {}:  tool.calibration, that is, below tool:\n  calibration: {}\n", command.config.string(),
                                      yaml_text(relative_name(fs::absolute(task.file), folder).string()));
    }
    return ExitCode::done;
}

}  // namespace palpate
