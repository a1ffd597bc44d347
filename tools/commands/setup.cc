// palpate setup: the table and the part are touched, and the configuration told where they are.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <ostream>

#include "config/editor.h"
#include "config/reader.h"
#include "devices/errors.h"
#include "planner/number_text.h"
#include "tools/attended_machine.h"
#include "tools/calibration_file.h"
#include "tools/commands/commands.h"
#include "tools/config_change.h"
#include "tools/machine.h"
#include "tools/session_files.h"
#include "tools/session_plan.h"
#include "tools/table_setup.h"
#include "tools/terminal/consent.h"
#include "tools/tool_text.h"

namespace palpate {
namespace {

// Of epsilon, between what the ball touches and the workspace's faces. Known tables end two inside of these; with three in all a block on a
// table was not closed.
constexpr double kMargin = 6.0;

struct Setup {
    SessionConfig config;
    std::array<Point, 3> table_places;
    std::optional<Box> part;  // as the user says
    Point center;             // x and y of a place on the part
    double margin = 0.0;      // mm
};

Point middle_of(const std::vector<double>& given, const Box& otherwise) {
    if (given.empty()) return otherwise.center();
    return {given[0], given[1], 0.0};
}

Setup task_of(const SetupCommand& command) {
    Setup task;
    task.config = with_its_files(read_config(command.config, command.overrides));
    const SessionConfig& config = task.config;
    if (!config.machine) throw SetupError(fmt::format("machine: missing; a setup touches with {}", connection_keys()));
    if (!config.tool) throw SetupError("tool: missing; say with which ball is touched: tool: {ball: {diameter: 2}}");
    constexpr double kUpwards = 1 - 1e-9;
    if (config.tool->axis.z() < kUpwards) {
        throw SetupError("tool.stylus.axis: leads elsewhere than straight up, and a setup touches straight down: write workspace by hand");
    }
    if (command.around.has_value() == !command.box.empty()) {
        throw SetupError("give --around Z, to have the part touched from its sides at that height, or --box with the part's corners");
    }
    const Box& limits = config.machine->limits;
    task.table_places = default_table_places(limits);
    for (std::size_t k = 0; k < command.table.size() / 2; ++k) {
        task.table_places.at(k) = {command.table[2 * k], command.table[2 * k + 1], limits.max.z()};
    }
    if (const auto& box = command.box; !box.empty()) {
        task.part = Box{{box[0], box[1], box[2]}, {box[3], box[4], box[5]}};
        if (!task.part->is_valid())
            throw SetupError("--box: each coordinate of the second corner has to be greater than that of the first");
    }
    task.center = middle_of(command.center, task.part.value_or(limits));
    task.margin = command.margin.value_or(kMargin * config.probing.epsilon);
    for (const Point& p : {task.table_places[0], task.table_places[1], task.table_places[2],
                           Point(task.center.x(), task.center.y(), command.around.value_or(limits.max.z()))}) {
        if (limits.contains(p)) continue;
        throw SetupError(
            fmt::format("{} is outside machine.limits, {} to {}", point_text(p), point_text(limits.min), point_text(limits.max)));
    }
    return task;
}

// Touches one place after another, each once the operator has agreed, and comes back up.
class Toucher {
public:
    Toucher(const SetupCommand& command, GuardedMachine& guarded, const Feeds& feeds, Output& output, StopSignals& signals)
        : command_(command), device_(guarded.device()), feeds_(feeds), console_(output.console), signals_(signals) {
        height_ = device_.position().z();
    }

    // mm: at which the tool goes from place to place.
    [[nodiscard]] double height() const { return height_; }
    // From above the start of the touch down to it, towards `target` until something is touched, and back. Nothing if nothing is.
    std::optional<Point> touch(const std::string& what, const Point& start, const Point& target) {
        const Point above(start.x(), start.y(), std::max(height_, start.z()));
        ask_consent(fmt::format("{}\nIt will move, guarded and at {:.6g} mm/s, from {} to {}, {}towards {} until it touches, and back.",
                                what, feeds_.probe_mm_per_s, point_text(device_.position()), point_text(above),
                                start == above ? "" : fmt::format("down to {}, ", point_text(start)), point_text(target)),
                    command_.yes, console_, signals_, true);
        follow({above, start}, "the way to where a touch begins");
        const MoveResult result = move_past_sparks(device_, target, Pace::probe);
        follow({start, above}, "the way back from a touch");
        switch (result.outcome) {
            case MoveResult::Outcome::contact:
                return result.position;
            case MoveResult::Outcome::reached:
                return std::nullopt;
            default:
                throw DeviceError(fmt::format("the touch near {} could not be measured: the probe triggers and lets go; look at its wiring",
                                              point_text(result.position)));
        }
    }

private:
    // Nothing has shown yet that space is free: no faster than a probe.
    void follow(const std::vector<Point>& way, const char* during) {
        for (const Point& place : way) {
            const MoveResult result = move_past_sparks(device_, place, Pace::probe);
            if (result.outcome != MoveResult::Outcome::reached) throw UnexpectedContact(result.position, during);
        }
    }

    const SetupCommand& command_;
    ProbeDevice& device_;
    const Feeds feeds_;
    Console& console_;
    StopSignals& signals_;
    double height_ = 0.0;
};

TablePlane touch_table(const Setup& task, Toucher& toucher) {
    const Box& limits = task.config.machine->limits;
    std::array<Point, 3> touched;
    for (std::size_t k = 0; k < touched.size(); ++k) {
        const Point& place = task.table_places.at(k);
        const Point end(place.x(), place.y(), limits.min.z());
        const auto contact = toucher.touch(fmt::format("table      touch {} of 3", k + 1), {place.x(), place.y(), toucher.height()}, end);
        if (!contact) {
            throw DeviceError(fmt::format(
                "nothing was touched down to {}, the end of machine.limits: the table lies lower, or the probe is dead. Press it by hand "
                "(palpate check), and look whether machine.limits let the ball come down to the table",
                point_text(end)));
        }
        touched.at(k) = *contact;
    }
    return table_through(touched, touching_radius(task.config));
}

struct TouchedPart {
    Box box;
    std::vector<PartTouch> touches;
};

// Down onto the part; what is as low as the table is no part.
std::optional<PartTouch> touch_top(const Setup& task, const TablePlane& table, const Point& place, Toucher& toucher) {
    const MachineConfig& machine = *task.config.machine;
    const double radius = touching_radius(task.config);
    const double lowest = table.touched_height(place.x(), place.y(), radius) + 2 * machine.touch_error();
    const Point end(place.x(), place.y(), std::max(lowest, machine.limits.min.z()));
    const auto contact = toucher.touch("part       touch from above", {place.x(), place.y(), toucher.height()}, end);
    if (!contact) return std::nullopt;
    return PartTouch{-Vector::UnitZ(), *contact};
}

// mm: above it the ball is clear of the table at every place of the limits.
double least_height(const Setup& task, const TablePlane& table) {
    double least = 0;
    const Box& limits = task.config.machine->limits;
    for (const double x : {limits.min.x(), limits.max.x()}) {
        for (const double y : {limits.min.y(), limits.max.y()}) {
            const double height = table.touched_height(x, y, touching_radius(task.config));
            least = (x == limits.min.x() && y == limits.min.y()) ? height : std::max(least, height);
        }
    }
    return least + 2 * task.config.machine->touch_error();
}

TouchedPart touch_around(const Setup& task, const TablePlane& table, double height, Toucher& toucher) {
    const MachineConfig& machine = *task.config.machine;
    const ToolShape& tool = *task.config.tool;
    const double radius = touching_radius(task.config);
    if (const double least = least_height(task, table); height < least) {
        throw SetupError(
            fmt::format("--around {:.6g}: the ball would meet the table, which it touches as high as {:.6g} mm", height, least));
    }
    const auto top = touch_top(task, table, task.center, toucher);
    if (!top) {
        throw DeviceError(fmt::format("no part was touched from above at x, y = {:.6g}, {:.6g} mm: give --center a place on it",
                                      task.center.x(), task.center.y()));
    }
    const double part_top = top->position.z() - radius;
    if (tool.stylus && tool.holder && height + tool.stylus->length - tool.holder->diameter / 2 < part_top) {
        throw SetupError(
            fmt::format("--around {:.6g}: the holder would meet the part, whose top is at {:.6g} mm: touch it higher", height, part_top));
    }
    TouchedPart part{{{0, 0, table.height(task.center.x(), task.center.y())}, {0, 0, part_top}}, {*top}};
    Point middle(task.center.x(), task.center.y(), height);
    for (int axis = 0; axis < 2; ++axis) {
        for (const bool from_max : {false, true}) {
            Point start = middle;
            start[axis] = (from_max ? machine.limits.max : machine.limits.min)[axis];
            const Vector approach = (from_max ? -1.0 : 1.0) * Vector::Unit(axis);
            const auto contact =
                toucher.touch(fmt::format("part       touch from {}{}", from_max ? '+' : '-', axis == 0 ? 'x' : 'y'), start, middle);
            if (!contact) {
                throw DeviceError(
                    fmt::format("nothing was touched on the way to {}: no part is there at that height; give --center a "
                                "place on it, or another height to --around",
                                point_text(middle)));
            }
            part.touches.push_back({approach, *contact});
            (from_max ? part.box.max : part.box.min)[axis] = (*contact + radius * approach)[axis];
        }
        middle[axis] = (part.box.min[axis] + part.box.max[axis]) / 2;
    }
    return part;
}

TouchedPart touch_box(const Setup& task, const TablePlane& table, Toucher& toucher) {
    TouchedPart part{*task.part, {}};
    const auto top = touch_top(task, table, task.center, toucher);
    if (!top) {
        spdlog::warn(
            "no part was touched from above at x, y = {:.6g}, {:.6g} mm: no seed ray is known to meet it; give --center a place on it",
            task.center.x(), task.center.y());
        return part;
    }
    const double higher = top->position.z() - touching_radius(task.config) - part.box.max.z();
    if (higher > 2 * task.config.machine->touch_error()) {
        throw SetupError(fmt::format("--box: the part is {:.3g} mm higher than it says, as touched at {}: correct it", higher,
                                     point_text(top->position)));
    }
    part.touches.push_back(*top);
    return part;
}

void tell(const TablePlane& table, const TouchedPart& part, const TableSetup& setup, const std::vector<KeyEdit>& edits, std::ostream& out) {
    const Point middle = setup.workspace.center();
    out << fmt::format("table       z = {:.3f} mm at x, y = {:.6g}, {:.6g}, tilted by {:.3f} degrees, {:.3f} mm over the workspace{}\n",
                       table.height(middle.x(), middle.y()), middle.x(), middle.y(), table.tilt_degrees(), table.rise_over(setup.workspace),
                       setup.is_tilted ? ": a half-space" : "")
        << fmt::format("part        {} to {}, as far as touched; parts that are wider elsewhere need a greater --margin\n",
                       point_text(part.box.min), point_text(part.box.max))
        << fmt::format("workspace   {} to {}\n", point_text(setup.workspace.min), point_text(setup.workspace.max))
        << fmt::format("seed rays   {}\n", setup.seed_rays.size());
    for (const KeyEdit& edit : edits) out << "  " << edit.key << ": " << edit.value << '\n';
    out.flush();
}

// The text of the configuration with these keys. Throws SetupError if no session could begin with it.
std::string changed_text(const SetupCommand& command, const std::vector<KeyEdit>& edits) {
    const std::string text = edited_config(read_file(command.config), command.config, edits);
    (void)machine_workspace(read_config_text(text, command.config, command.overrides));
    return text;
}

}  // namespace

ExitCode run(const SetupCommand& command, Output& output) {
    StopSignals signals;
    const Setup task = task_of(command);
    const MachineConfig& machine = *task.config.machine;
    GuardedMachine guarded(connect(machine, signals.token()), machine, signals.token(), [&] { signals.pause(); });
    const MachineReport report = guarded.machine().report();
    output.results << "tool        at " << point_text(report.position) << "; " << describe(*task.config.tool) << std::endl;
    const std::string what = fmt::format(
        "It will touch the table in three places, straight down from the height at which it is, and the part {}. It goes from place to "
        "place "
        "at that height, which has to be above everything; each touch is shown and asked for before.",
        command.around ? fmt::format("from above and from four sides, with the ball's centre at z = {:.6g} mm", *command.around)
                       : std::string("from above"));
    let_move(guarded.machine(), report, machine, what, command.yes, output.console, signals);
    Toucher toucher(command, guarded, machine.motion.feeds, output, signals);
    const TablePlane table = touch_table(task, toucher);
    const TouchedPart part = command.around ? touch_around(task, table, *command.around, toucher) : touch_box(task, table, toucher);
    const TableSetup setup = propose_setup(task.config, table, part.box, part.touches, touching_radius(task.config), task.margin);
    const std::vector<KeyEdit> edits = edits_of(setup, task.config);
    tell(table, part, setup, edits, output.results);
    const std::string text = changed_text(command, edits);
    ask_to_change(fmt::format("These keys will be put into {}, which is kept as it was beside it.", command.config.string()), command.yes,
                  output.console, signals);
    signals.release();
    const std::filesystem::path kept = change_config(command.config, text);
    output.results << command.config.string() << " is set up; as it was: " << kept.string() << '\n'
                   << "next: palpate check " << shell_word(command.config.string()) << '\n';
    return ExitCode::done;
}

}  // namespace palpate
