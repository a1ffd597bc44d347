#include "devices/decorators/multi_touch_device.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "devices/decorators/internal/touch_samples.h"
#include "devices/errors.h"
#include "devices/internal/way.h"

namespace palpate {
namespace {

using Outcome = MoveResult::Outcome;
using Kind = DeviceEvent::Kind;

// The way back was passed just now, so that a trigger on it is a false one. So many in a row are not.
constexpr int kMaxBackMoves = 4;
// A touch that is not met again is looked for once more: a probe may miss one.
constexpr int kMissesOfNothing = 2;
// So many touches more are needed at most because some did not hold.
constexpr int kMaxDoubts = 3;
// mm: far above rounding, far below the resolution of any machine.
constexpr double kSamePlace = 1e-6;
// Of the retract: a tool that is back by this has been taken back by its device.
constexpr double kIsBack = 0.5;

void append(std::vector<DeviceEvent>& events, const std::vector<DeviceEvent>& more) {
    events.insert(events.end(), more.begin(), more.end());
}

}  // namespace

struct MultiTouchDevice::Verdict {
    enum class Kind { touched, scattered, nothing };
    Kind kind;
    double place;  // mm along the way
};

struct MultiTouchDevice::Touched {
    double place;  // mm along the way
    bool held;
};

MultiTouchDevice::MultiTouchDevice(ProbeDevice& device, const MultiTouchOptions& options, double retract_mm)
    : device_(device), options_(options), retract_mm_(retract_mm) {
    if (options.samples < 1) throw std::invalid_argument("touches: at least 1 sample is needed");
    if (!(options.tolerance_mm > 0) || !std::isfinite(options.tolerance_mm)) {
        throw std::invalid_argument("touches: the tolerance must be greater than 0 mm");
    }
    if (options.retries < 0) throw std::invalid_argument("touches: the number of retries is negative");
    if (!(retract_mm >= 0) || !std::isfinite(retract_mm)) throw std::invalid_argument("touches: the retract must be 0 mm or more");
}

double MultiTouchDevice::overreach() const { return std::max(kOverreach, 2 * options_.tolerance_mm); }

MoveResult MultiTouchDevice::guarded_move(const Point& target, Pace pace) {
    const Point start = device_.position();
    if (!is_measured(pace) || start == target) return device_.guarded_move(target, pace);
    const Way way(start, target);
    Events events;
    for (int triggers = 0;; ++triggers) {
        MoveResult result = device_.guarded_move(target, pace);
        append(events, result.events);
        if (result.outcome == Outcome::contact) {
            const double first = way.place_of(result.position);
            const Verdict verdict = measure(way, first, result.held, pace, events);
            // Where the tool travels, space is known to be free: the trigger was a false one.
            if (verdict.kind == Verdict::Kind::nothing && pace == Pace::travel && triggers < kMaxFalseTriggers) continue;
            result.position = way.at(verdict.place);
            switch (verdict.kind) {
                case Verdict::Kind::touched:
                    // A device that rests on what it touches may have touched a little farther.
                    if (way.place_of(device_.position()) > verdict.place + kSamePlace) go_back(way, verdict.place, events);
                    break;
                case Verdict::Kind::scattered:
                    result.outcome = Outcome::failed;
                    break;
                case Verdict::Kind::nothing:
                    result.outcome = pace == Pace::travel ? Outcome::failed : Outcome::vanished;
                    go_back(way, verdict.place, events);
                    break;
            }
        }
        result.events = std::move(events);
        result.held = true;
        return result;
    }
}

MultiTouchDevice::Verdict MultiTouchDevice::measure(const Way& way, double first, bool held, Pace pace, Events& events) {
    const bool is_probe = pace == Pace::probe;
    const bool is_single = !is_probe || (options_.samples == 1 && !options_.discard_first);
    const bool needs_confirmation = is_probe ? options_.confirm : options_.confirm_travel;
    bool is_discarding = is_probe && options_.discard_first;
    TouchSamples samples(is_single ? (needs_confirmation ? 2 : 1) : static_cast<std::size_t>(options_.samples));
    if (is_single) samples.add(first);
    // Two sparks can agree by chance; touches that did not hold have to be outnumbered.
    int doubts = 0;
    const auto note_doubt = [&](bool is_held) {
        if (is_held || samples.is_alone() || doubts == kMaxDoubts) return;
        samples.need_one_more();
        ++doubts;
    };
    note_doubt(held);

    int met = 0;
    int missed = 0;
    for (int retries = 0;;) {
        double place = first;
        if (samples.is_complete()) {
            if (samples.range() <= options_.tolerance_mm) {
                return {Verdict::Kind::touched, is_single ? samples.earliest() : samples.median()};
            }
            place = samples.median();
            events.push_back({Kind::scattered_touch, way.at(samples.drop_farthest())});
        } else if (const auto touched = touch_again(way, first, events); !touched) {
            if (++missed >= kMissesOfNothing && missed > met) {
                events.push_back({Kind::spurious_trigger, way.at(first)});
                return {Verdict::Kind::nothing, first};
            }
            if (met == 0) {
                samples.need_one_more();  // a false trigger and another may lie together by chance
                continue;
            }
            events.push_back({Kind::scattered_touch, way.at(first + overreach())});
        } else if (touched->place < first - overreach()) {
            events.push_back({Kind::spurious_trigger, way.at(touched->place)});
        } else {
            ++met;
            note_doubt(touched->held);
            if (!is_discarding) samples.add(touched->place);
            is_discarding = false;
            continue;
        }
        if (++retries > options_.retries) return {Verdict::Kind::scattered, place};
    }
}

std::optional<MultiTouchDevice::Touched> MultiTouchDevice::touch_again(const Way& way, double first, Events& events) {
    go_back(way, first, events);
    const MoveResult touch = device_.guarded_move(way.at(first + overreach()), Pace::touch);
    append(events, touch.events);
    if (touch.outcome == Outcome::reached) return std::nullopt;
    return Touched{way.place_of(touch.position), touch.held};
}

void MultiTouchDevice::go_back(const Way& way, double place, Events& events) {
    const double back = std::max(0.0, place - retract_mm_);
    Point touched = way.at(place);
    for (int k = 0; k < kMaxBackMoves; ++k) {
        if (way.place_of(device_.position()) - back <= kIsBack * std::min(retract_mm_, place) + kSamePlace) return;
        const MoveResult move = device_.guarded_move(way.at(back), Pace::probe);
        append(events, move.events);
        if (move.outcome == Outcome::reached) return;
        touched = move.position;
        events.push_back({Kind::spurious_trigger, touched});
    }
    throw UnexpectedContact(touched, "the way back from a touch");
}

}  // namespace palpate
