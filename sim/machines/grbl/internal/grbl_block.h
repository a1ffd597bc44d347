// What one line of G-code asks for, or the number of the error that it is.
#pragma once

#include <array>
#include <vector>

#include "planner/geometry.h"
#include "planner/machine_time.h"
#include "sim/machines/grbl/internal/grbl_words.h"

namespace palpate {

inline constexpr double kInch = 25.4;  // mm

// Numbers of G words in tenths: 382 is G38.2.
struct GrblModal {
    int motion = 0;
    std::size_t work_system = 0;  // 0 is G54
    bool inches = false;
    bool incremental = false;
    double feed_mm_per_min = 0.0;
    int spindle = 5;  // 3, 4 or 5 of M3 to M5
    bool mist = false;
    bool flood = false;
};

// Where the parser thinks that the tool is, and what work coordinates are. Machine coordinates, mm.
struct GrblFrame {
    static constexpr std::size_t kWorkSystems = 6;  // G54 to G59

    Point position = Point::Zero();
    std::array<Point, kWorkSystems> work{Point::Zero(), Point::Zero(), Point::Zero(), Point::Zero(), Point::Zero(), Point::Zero()};
    Point shift = Point::Zero();  // G92

    [[nodiscard]] Point offset(const GrblModal& modal) const { return work[modal.work_system] + shift; }
};

struct GrblBlock {
    enum class Action { none, rapid, line, probe, dwell, set_work_system, set_shift };

    int error = 0;  // if not 0, nothing of the block is done
    Action action = Action::none;
    GrblModal modal{};             // afterwards
    Point target = Point::Zero();  // of a motion, machine coordinates; or the new offset
    Seconds dwell{0.0};
    std::size_t work_system = 0;  // to set
};

enum class GrblLineKind { code, jog };

// A jog takes its feed from its own line, and leaves the modal state as it was.
[[nodiscard]] GrblBlock interpret(const std::vector<GrblWord>& words, const GrblModal& modal, const GrblFrame& frame,
                                  GrblLineKind kind = GrblLineKind::code);

}  // namespace palpate
