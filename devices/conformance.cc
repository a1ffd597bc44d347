#include "devices/conformance.h"

#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "devices/errors.h"
#include "planner/number_text.h"

namespace palpate {
namespace {

using namespace std::chrono_literals;
using Outcome = MoveResult::Outcome;
using Hand = ConformanceAudience::Hand;
using Verdict = Conformance::Verdict;

// Both ends are rounded by driver and machine.
constexpr double kRoundings = 3.0;
// Of its feed: faster than that a move was faster than it was told, for clocks and for what the answer takes.
constexpr double kTooFast = 1.1;
// What a move may take beyond twice what it is reckoned to.
constexpr Seconds kMoreTime{1.0};
// A stop is at an end by then (devices/FACTS.md, "Safety floor").
constexpr Seconds kStopTime{5.0};
// Of a move that is stopped, what it has gone by then.
constexpr double kStoppedAt = 0.3;
// A move is to take so long, so that it can be stopped in its middle.
constexpr double kLongMove_s = 2.0;
constexpr int kShortMoves = 20;
constexpr auto kLook = 20ms;

struct Failed {
    std::string why;
};
struct Skipped {
    std::string why;
};

class Trial {
public:
    Trial(const std::function<std::unique_ptr<Machine>(const StopToken&)>& connect, Clock& clock, const ConformanceOptions& options,
          const ConformanceAudience& audience, const StopToken& stop)
        : connect_(connect), clock_(clock), options_(options), audience_(audience), stop_(stop) {}

    bool run() {
        if (!step("connects, and reports no problem", [&] { return connects(); })) return false;
        if (!step("gets ready", [&] { return gets_ready(); })) return false;
        // Until the probe has shown that it works, nothing is faster than a probe (devices/FACTS.md, "Safety floor"). Where one of these is
        // bad, nobody knows what another move would do.
        const bool is_safe = step("refuses to move towards a touch with the probe closed", [&] { return refuses_closed_probe(); }) &&
                             step("ends a move at a touch, and draws back", [&] { return ends_at_touch(); }) &&
                             step("goes where it is told", [&] { return goes_where_it_is_told(); }) &&
                             step("keeps its feeds", [&] { return keeps_feeds(); }) &&
                             step("makes short moves without loss", [&] { return makes_short_moves(); }) &&
                             step("stops when it is told, and goes back", [&] { return stops(); });
        if (!is_safe) return false;
        audience_.tell(
            {Verdict::skipped, "stops when Palpate is gone in mid-move",
             "pull the cable, or end the program, in a long move, and look: what the controller is known to do is in devices/README.md"});
        return true;
    }

private:
    // What it returns is what was measured. True unless it is bad.
    template <class Try>
    bool step(const char* what, const Try& attempt) {
        if (stop_.stop_requested()) throw Stopped("stopped by the operator");
        Conformance found{Verdict::good, what, ""};
        try {
            found.why = attempt();
        } catch (const Failed& failed) {
            found = {Verdict::bad, what, failed.why};
        } catch (const Stopped&) {
            throw;
        } catch (const Skipped& skipped) {
            found = {Verdict::skipped, what, skipped.why};
        } catch (const DeviceError& error) {
            found = {Verdict::bad, what, error.what()};
        }
        audience_.tell(found);
        return found.verdict != Verdict::bad;
    }
    std::string connects() {
        machine_ = connect_(stop_);
        const MachineReport report = machine_->report();
        for (const MachineSetting& setting : report.settings) {
            if (!setting.problem.empty()) throw Failed{fmt::format("{}: {}, {}", setting.name, setting.value, setting.problem)};
        }
        return report.identity;
    }
    std::string gets_ready() {
        machine_->make_ready();
        centre_ = machine_->device().position();
        const Box& limits = options_.limits;
        if (!limits.contains(centre_, tolerance())) {
            throw Failed{fmt::format("the tool stands at {}, outside machine.limits: move it inside", point_text(centre_))};
        }
        // The longer way along each axis, within limits.
        for (int axis = 0; axis < 3; ++axis) {
            const double up = std::min(options_.reach_mm, limits.max[axis] - centre_[axis]);
            const double down = std::min(options_.reach_mm, centre_[axis] - limits.min[axis]);
            reach_[axis] = up >= down ? up : -down;
        }
        return fmt::format("at {}; it will stay between that and {}", point_text(centre_), point_text(centre_ + reach_));
    }
    std::string goes_where_it_is_told() {
        double worst = 0;
        for (const double share : {0.25, 0.5, 1.0}) {
            for (int corner = 1; corner <= 8; ++corner) {
                const Vector part((corner & 1) != 0 ? 1 : 0, (corner & 2) != 0 ? 1 : 0, (corner & 4) != 0 ? 1 : 0);
                const Point target = centre_ + share * reach_.cwiseProduct(part);
                go(target, corner % 2 == 0 ? fastest() : Pace::probe);
                const double off = (machine_->report().position - target).norm();
                worst = std::max(worst, off);
                if (off > tolerance()) {
                    throw Failed{
                        fmt::format("after a move to {} it reports that it is {} off that", point_text(target), number_text(off, " mm"))};
                }
            }
        }
        go(centre_, fastest());
        return fmt::format("24 moves, {} off at most", number_text(worst, " mm"));
    }
    std::string keeps_feeds() {
        const Point far = centre_ + longest();
        std::string measured;
        for (const Pace pace : {Pace::travel, Pace::probe, Pace::touch}) {
            if (pace == Pace::travel && !is_probe_shown_) continue;
            const double feed = options_.motion.feeds.of(pace);
            // At a slow feed a part of the way will do.
            const double length = std::min(longest().norm(), std::max(1.0, feed * kLongMove_s));
            const Point target = centre_ + length * (far - centre_).normalized();
            const Seconds reckoned = move_duration(options_.motion, length, feed);
            const Seconds took = time([&] { go(target, pace); });
            go(centre_, fastest());
            if (took.count() * kTooFast < length / feed) {
                throw Failed{fmt::format("{} at {} took {}: it was faster than it was told", number_text(length, " mm"),
                                         number_text(feed, " mm/s"), number_text(took.count(), " s"))};
            }
            if (took > 2 * reckoned + kMoreTime) {
                throw Failed{fmt::format("{} at {} took {}, where {} was reckoned: is an override active, is machine.acceleration right?",
                                         number_text(length, " mm"), number_text(feed, " mm/s"), number_text(took.count(), " s"),
                                         number_text(reckoned.count(), " s"))};
            }
            measured += fmt::format("{}{:.3g} s for {:.3g}", measured.empty() ? "" : ", ", took.count(), reckoned.count());
        }
        return measured + " reckoned";
    }
    std::string makes_short_moves() {
        const Vector step = 20 * options_.motion.resolution_mm * longest().normalized();
        const Seconds took = time([&] {
            for (int k = 0; k < kShortMoves; ++k) go(centre_ + (k % 2 == 0 ? 1 : 0) * step, fastest());
            go(centre_, fastest());  // of no length
        });
        return fmt::format("{:.0f} ms each", 1000 * took.count() / (kShortMoves + 1));
    }
    std::string stops() {
        StopSource source;
        machine_.reset();
        machine_ = connect_(source.token());
        machine_->make_ready();
        const Vector way = longest();
        // Slow enough to be stopped on the way.
        Pace pace = fastest();
        if (way.norm() / options_.motion.feeds.travel_mm_per_s < kLongMove_s / 2) pace = Pace::probe;
        const Seconds reckoned = move_duration(options_.motion, way.norm(), options_.motion.feeds.of(pace));
        std::jthread hand([&] {
            const auto until = std::chrono::steady_clock::now() + kStoppedAt * reckoned;
            while (std::chrono::steady_clock::now() < until && !stop_.stop_requested()) std::this_thread::sleep_for(kLook);
            source.request_stop();
        });
        bool is_stopped = false;
        const Seconds took = time([&] {
            try {
                (void)machine_->device().guarded_move(centre_ + way, pace);
            } catch (const Stopped&) {
                is_stopped = true;
            }
        });
        hand.join();
        const Point rest = machine_->device().position();
        const bool is_trusted = machine_->is_position_trusted();
        const double off = (machine_->report().position - centre_).norm();
        machine_.reset();
        if (!is_stopped) throw Failed{fmt::format("a move of {} was not ended by a stop in its middle", number_text(way.norm(), " mm"))};
        const Seconds stopping = took - kStoppedAt * reckoned;
        // Going back takes as long as the way at the feed of probes.
        const Seconds back{kStoppedAt * way.norm() / options_.motion.feeds.probe_mm_per_s};
        if (stopping > kStopTime + back) throw Failed{fmt::format("it took {} to stop and go back", number_text(stopping.count(), " s"))};
        if (off > tolerance() || (rest - centre_).norm() > tolerance()) {
            throw Failed{fmt::format("it rests {} from where the move began", number_text(off, " mm"))};
        }
        if (!is_trusted) throw Failed{"after it its position is not trusted any more"};
        return fmt::format("{:.2g} s with the way back", stopping.count());
    }
    std::string refuses_closed_probe() {
        require_hand();
        audience_.ask_hand(Hand::hold);
        wait_for_probe(true);
        // Not farther than the probe gives way: nothing would end it.
        const double length = std::min(longest().norm(), options_.motion.overtravel_mm);
        bool is_refused = false;
        try {
            (void)machine_->device().guarded_move(centre_ + length * longest().normalized(), Pace::touch);
        } catch (const ProbeClosed&) {
            is_refused = true;
        }
        machine_.reset();
        audience_.ask_hand(Hand::let_go);
        machine_ = connect_(stop_);
        const double gone = (machine_->report().position - centre_).norm();
        wait_for_probe(false);
        (void)gets_ready();  // some controllers are locked by it, and may be homed: what follows is tried where it is then
        if (!is_refused) throw Failed{"it did not say so"};
        if (gone > tolerance()) throw Failed{fmt::format("it moved by {}", number_text(gone, " mm"))};
        return fmt::format("it moved by {}", number_text(gone, " mm"));
    }
    std::string ends_at_touch() {
        require_hand();
        wait_for_probe(false);
        go(centre_, Pace::probe);
        audience_.ask_hand(Hand::tap);
        const MoveResult result = machine_->device().guarded_move(centre_ + longest(), Pace::probe);
        if (result.outcome != Outcome::contact) throw Failed{"the move went on to its end, although the probe was to be tapped on its way"};
        const double place = (result.position - centre_).norm();
        const double rest = (machine_->device().position() - centre_).norm();
        if (rest > place) throw Failed{fmt::format("it rests {} behind the touch", number_text(rest - place, " mm"))};
        if (machine_->is_probe_closed()) throw Failed{"the probe is closed where it rests"};
        is_probe_shown_ = true;
        return fmt::format("{} before the touch", number_text(place - rest, " mm"));
    }

    void go(const Point& target, Pace pace) {
        const MoveResult result = machine_->device().guarded_move(target, pace);
        if (result.outcome != Outcome::reached) {
            throw Failed{fmt::format("on the way to {} something was touched at {}: is the space free?", point_text(target),
                                     point_text(result.position))};
        }
        const double off = (machine_->device().position() - target).norm();
        if (off > tolerance()) throw Failed{fmt::format("a move to {} ended {} off that", point_text(target), number_text(off, " mm"))};
    }
    void require_hand() const {
        if (!audience_.ask_hand) throw Skipped{"nobody is there to press the probe"};
    }
    void wait_for_probe(bool closed) {
        const auto until = clock_.now() + to_nanoseconds(options_.hand);
        while (machine_->is_probe_closed() != closed) {
            if (stop_.stop_requested()) throw Stopped("stopped by the operator");
            if (clock_.now() > until) throw Failed{closed ? "the probe was not seen to close" : "the probe was not seen to open"};
            clock_.sleep(kLook);
        }
    }
    [[nodiscard]] Vector longest() const {
        Eigen::Index axis = 0;
        reach_.cwiseAbs().maxCoeff(&axis);
        return reach_[axis] * Vector::Unit(axis);
    }
    [[nodiscard]] Pace fastest() const { return is_probe_shown_ ? Pace::travel : Pace::probe; }
    [[nodiscard]] double tolerance() const { return kRoundings * options_.motion.resolution_mm; }
    template <class Call>
    [[nodiscard]] Seconds time(const Call& call) const {
        const auto begun = clock_.now();
        call();
        return clock_.now() - begun;
    }

    const std::function<std::unique_ptr<Machine>(const StopToken&)>& connect_;
    Clock& clock_;
    const ConformanceOptions& options_;
    const ConformanceAudience& audience_;
    const StopToken stop_;
    std::unique_ptr<Machine> machine_;
    bool is_probe_shown_ = false;
    Point centre_ = Point::Zero();
    Vector reach_ = Vector::Zero();
};

}  // namespace

bool try_conformance(const std::function<std::unique_ptr<Machine>(const StopToken&)>& connect, Clock& clock,
                     const ConformanceOptions& options, const ConformanceAudience& audience, const StopToken& stop) {
    return Trial(connect, clock, options, audience, stop).run();
}

}  // namespace palpate
