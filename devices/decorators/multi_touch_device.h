// Measures every touch again, slowly, until touches agree; finds out triggers where nothing is.
#pragma once

#include <optional>
#include <vector>

#include "devices/probe_device.h"

namespace palpate {

struct Way;

struct MultiTouchOptions {
    int samples = 1;              // >= 1: slow touches whose median counts; 1: the first touch counts, if a slow one agrees
    double tolerance_mm = 0.025;  // > 0: touches agree if they lie within it (Klipper's limit)
    int retries = 3;              // >= 0: touches in place of those that do not agree
    bool discard_first = false;   // the first slow touch does not count
    bool confirm = true;          // with one sample: whether a slow touch has to agree
    bool confirm_travel = true;   // whether a touch during travel is looked at again
};

// Moves at Pace::probe and, if `confirm_travel`, Pace::travel; those at Pace::touch pass as they are.
//
// After a contact the tool goes back by `retract_mm` unless the device did, and touches again along the same line at Pace::touch, up to a
// little past the first contact but never past the target.
//  - Touches agree within the tolerance: a contact at their median, on the straight line from the start to the target. If not, the
//    one farthest from the median is dropped (event scattered_touch), the others are kept, and one more is taken, `retries` times at most;
//    then the move has failed.
//  - A touch that did not hold (MoveResult::held) asks for one more that agrees.
//  - Two touches and more meet nothing, and fewer meet something: a false trigger (event spurious_trigger), or a probe that has just
//    died. A probe's move ends (Outcome::vanished), before the place: only a touch elsewhere can tell. Travel goes on.
//  - A trigger far short of the first contact is a false one: the tool has passed there. It counts as a retry.
// A touch as near to the target as touches scatter may so be taken for none: the target was reached.
// After a contact the tool rests before the touched point, or at it, where the device does not retract.
class MultiTouchDevice final : public ProbeDevice {
public:
    // `device` must outlive this. Throws std::invalid_argument on options out of range.
    MultiTouchDevice(ProbeDevice& device, const MultiTouchOptions& options, double retract_mm);

    [[nodiscard]] Point position() const override { return device_.position(); }
    // Throws UnexpectedContact if the probe keeps triggering on the way back from a touch, and what the device throws. Travel on which
    // it triggers falsely more than kMaxFalseTriggers times fails.
    [[nodiscard]] MoveResult guarded_move(const Point& target, Pace pace) override;
    void stop() override { device_.stop(); }

    // mm: how far a slow touch looks past the first contact, or twice the tolerance if that is more. First touches are off by
    // some hundredths (37 µm of pre-travel and more).
    static constexpr double kOverreach = 0.2;

private:
    struct Verdict;
    struct Touched;
    using Events = std::vector<DeviceEvent>;

    [[nodiscard]] bool is_measured(Pace pace) const { return pace == Pace::probe || (pace == Pace::travel && options_.confirm_travel); }
    // What is at `first` (mm along the way), where the tool was stopped.
    [[nodiscard]] Verdict measure(const Way& way, double first, bool held, Pace pace, Events& events);
    // mm along the way; nothing if nothing is met.
    [[nodiscard]] std::optional<Touched> touch_again(const Way& way, double first, Events& events);
    // To where a touch at `place` can be approached from, if the tool is nearer than that.
    void go_back(const Way& way, double place, Events& events);
    [[nodiscard]] double overreach() const;

    ProbeDevice& device_;
    const MultiTouchOptions options_;
    const double retract_mm_;
};

}  // namespace palpate
