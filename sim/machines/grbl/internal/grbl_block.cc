#include "sim/machines/grbl/internal/grbl_block.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string_view>

#include "sim/machines/grbl/internal/grbl_errors.h"

namespace palpate {
namespace {

constexpr double kSamePlace = 1e-6;  // mm: far below a step
constexpr int kNoMotion = 800;
constexpr double kNoSuchCode = 100.0;  // G99 is the last

enum class AxisUse { none, motion, work_system, shift, clear_shift };

bool is_probe(int motion) { return motion >= 382 && motion <= 385; }

// The words of a line sorted out, before they are looked at together.
class Words {
public:
    explicit Words(const GrblModal& before) : modal(before) {}

    int add(const GrblWord& word) {
        if (word.letter == 'G') return add_g(word.value);
        if (word.letter == 'M') return add_m(word.value);
        constexpr std::string_view kKnown = "FLNPSTXYZ";
        if (kKnown.find(word.letter) == std::string_view::npos) return kUnsupported;
        if (!values_.try_emplace(word.letter, word.value).second) return kRepeatedWord;
        return word.value < 0.0 && word.letter < 'X' ? kNegative : 0;
    }

    [[nodiscard]] std::optional<double> value(char letter) const {
        const auto it = values_.find(letter);
        return it == values_.end() ? std::nullopt : std::optional(it->second);
    }
    [[nodiscard]] bool has_axes() const { return values_.contains('X') || values_.contains('Y') || values_.contains('Z'); }

    GrblModal modal;
    AxisUse axis_use = AxisUse::none;
    bool dwell = false;
    bool machine_coordinates = false;
    bool has_motion_word = false;

private:
    enum class Group { none, motion, plane, distance, feed, units, work, spindle, coolant, other };

    int take(Group group) { return groups_.insert(group).second ? 0 : kModalGroup; }

    int use_axes(AxisUse use) {
        if (axis_use != AxisUse::none) return kAxisConflict;
        axis_use = use;
        return 0;
    }

    int set_motion(int code) {
        modal.motion = code;
        has_motion_word = true;
        if (code != kNoMotion) {
            if (const int error = use_axes(AxisUse::motion)) return error;
        }
        return take(Group::motion);
    }

    int add_g(double value) {
        const double tenths = std::round(value * 10);
        if (value >= kNoSuchCode) return kUnsupported;  // nor a number that an int holds
        if (value < 0.0 || std::abs(tenths - value * 10) > 1e-6) return kNotWhole;
        const int code = static_cast<int>(tenths);
        if (code / 10 != 38 && code / 10 != 92 && code % 10 != 0) return kNotWhole;
        if (code >= 540 && code <= 590) {
            modal.work_system = static_cast<std::size_t>((code - 540) / 10);
            return take(Group::work);
        }
        switch (code) {
            case 0:
            case 10:
            case 382:
            case 383:
            case 384:
            case 385:
            case kNoMotion:
                return set_motion(code);
            case 40:
                dwell = true;
                return take(Group::none);
            case 100:
                return use_axes(AxisUse::work_system);
            case 920:
                return use_axes(AxisUse::shift);
            case 921:
                return use_axes(AxisUse::clear_shift);
            case 530:
                machine_coordinates = true;
                return take(Group::none);
            case 170:
            case 180:
            case 190:
                return take(Group::plane);
            case 200:
            case 210:
                modal.inches = code == 200;
                return take(Group::units);
            case 900:
            case 910:
                modal.incremental = code == 910;
                return take(Group::distance);
            case 940:
                return take(Group::feed);
            case 400:
            case 490:
            case 610:
                return 0;
            default:
                return kUnsupported;
        }
    }

    int add_m(double value) {
        constexpr std::array kKnown{0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 7.0, 8.0, 9.0, 30.0};
        if (std::ranges::find(kKnown, value) == kKnown.end()) return kUnsupported;
        const int code = static_cast<int>(value);
        if (code == 2 || code == 30) {  // the end of a program
            modal.spindle = 5;
            modal.mist = modal.flood = false;
        }
        if (code >= 3 && code <= 5) {
            modal.spindle = code;
            return take(Group::spindle);
        }
        if (code >= 7 && code <= 9) {
            modal.mist = code == 7 || (code == 8 && modal.mist);
            modal.flood = code == 8 || (code == 7 && modal.flood);
            return take(Group::coolant);
        }
        return 0;
    }

    std::map<char, double> values_;
    std::set<Group> groups_;
};

Point target_of(const Words& words, const GrblFrame& frame) {
    const double unit = words.modal.inches ? kInch : 1.0;
    const Point offset = words.machine_coordinates ? Point::Zero() : frame.offset(words.modal);
    Point target = frame.position;
    for (int axis = 0; axis < 3; ++axis) {
        const auto value = words.value(static_cast<char>('X' + axis));
        if (!value) continue;
        const bool from_here = words.modal.incremental && !words.machine_coordinates;
        target[axis] = *value * unit + (from_here ? frame.position[axis] : offset[axis]);
    }
    return target;
}

GrblBlock refuse(int error) {
    GrblBlock block;
    block.error = error;
    return block;
}

GrblBlock motion_of(const Words& words, const GrblFrame& frame) {
    GrblBlock block;
    block.modal = words.modal;
    const int motion = words.modal.motion;
    if (motion == kNoMotion) return refuse(kUselessAxisWords);
    if (words.machine_coordinates && motion != 0 && motion != 10) return refuse(kG53);
    if (motion != 0 && words.modal.feed_mm_per_min == 0.0) return refuse(kNoFeed);
    block.target = target_of(words, frame);
    if (is_probe(motion)) {
        if (!words.has_axes()) return refuse(kNoAxisWords);
        if ((block.target - frame.position).norm() < kSamePlace) return refuse(kAtTarget);
        block.action = GrblBlock::Action::probe;
    } else if (words.has_axes()) {
        block.action = motion == 0 ? GrblBlock::Action::rapid : GrblBlock::Action::line;
    }
    return block;
}

// G10 L2: the offset itself; L20: so that the tool is at the values given.
GrblBlock work_system_of(const Words& words, const GrblFrame& frame) {
    GrblBlock block;
    block.modal = words.modal;
    block.action = GrblBlock::Action::set_work_system;
    const auto which = words.value('P');
    const auto how = words.value('L');
    if (!words.has_axes()) return refuse(kNoAxisWords);
    if (!which || !how) return refuse(kMissingValue);
    if (*how != 2 && *how != 20) return refuse(kUnsupported);
    const double number = std::trunc(*which);  // as the firmware does
    if (number > static_cast<double>(GrblFrame::kWorkSystems)) return refuse(kNoSuchWorkSystem);
    block.work_system = number == 0.0 ? words.modal.work_system : static_cast<std::size_t>(number) - 1;
    block.target = frame.work[block.work_system];
    const double unit = words.modal.inches ? kInch : 1.0;
    for (int axis = 0; axis < 3; ++axis) {
        const auto value = words.value(static_cast<char>('X' + axis));
        if (value) block.target[axis] = *how == 2 ? *value * unit : frame.position[axis] - frame.shift[axis] - *value * unit;
    }
    return block;
}

GrblBlock shift_of(const Words& words, const GrblFrame& frame) {
    GrblBlock block;
    block.modal = words.modal;
    block.action = GrblBlock::Action::set_shift;
    if (words.axis_use == AxisUse::clear_shift) return block;
    if (!words.has_axes()) return refuse(kNoAxisWords);
    block.target = frame.shift;
    const double unit = words.modal.inches ? kInch : 1.0;
    for (int axis = 0; axis < 3; ++axis) {
        const auto value = words.value(static_cast<char>('X' + axis));
        if (value) block.target[axis] = frame.position[axis] - frame.work[words.modal.work_system][axis] - *value * unit;
    }
    return block;
}

GrblBlock dwell_of(const Words& words) {
    GrblBlock block;
    block.modal = words.modal;
    block.action = GrblBlock::Action::dwell;
    if (!words.value('P')) return refuse(kMissingValue);
    block.dwell = Seconds(*words.value('P'));
    return block;
}

}  // namespace

GrblBlock interpret(const std::vector<GrblWord>& line, const GrblModal& modal, const GrblFrame& frame, GrblLineKind kind) {
    Words words(modal);
    for (const GrblWord& word : line) {
        if (const int error = words.add(word)) return refuse(error);
    }
    const double unit = words.modal.inches ? kInch : 1.0;
    if (const auto feed = words.value('F')) words.modal.feed_mm_per_min = *feed * unit;
    if (kind == GrblLineKind::jog) {
        if (words.has_motion_word || words.dwell || words.axis_use != AxisUse::none) return refuse(kNotAJog);
        if (!words.has_axes()) return refuse(kNoAxisWords);
        if (words.value('F').value_or(0.0) == 0.0) return refuse(kNoFeed);
        words.modal.motion = 10;
    }
    if (words.has_axes() && words.axis_use == AxisUse::none) words.axis_use = AxisUse::motion;
    const bool uses_p = words.dwell || words.axis_use == AxisUse::work_system;
    if ((words.value('P') && !uses_p) || (words.value('L') && words.axis_use != AxisUse::work_system)) return refuse(kUnusedWords);
    if (words.dwell) return dwell_of(words);
    switch (words.axis_use) {
        case AxisUse::motion:
            return motion_of(words, frame);
        case AxisUse::work_system:
            return work_system_of(words, frame);
        case AxisUse::shift:
        case AxisUse::clear_shift:
            return shift_of(words, frame);
        case AxisUse::none:
            break;
    }
    GrblBlock block;
    block.modal = words.modal;
    return block;
}

}  // namespace palpate
