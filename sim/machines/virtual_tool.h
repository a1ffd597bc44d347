// The tool of a virtual machine: three axes that take time to move and to stop, a probe that closes on what it meets, and an
// account of its own of all that must not happen. Every virtual controller moves one of these.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include "devices/motion_model.h"
#include "planner/region.h"
#include "sim/objects/obstacle.h"
#include "sim/probe/probe_errors.h"

namespace palpate {

class ProbeInput;
struct Leg;
struct ToolMotion;

struct VirtualToolOptions {
    MotionModel motion;                                             // its feeds are not used: every move brings its own
    Point start = Point::Zero();                                    // mm, machine coordinates
    Point origin = Point::Zero();                                   // machine coordinates of the obstacle's origin
    Box limits{Point::Constant(-1000.0), Point::Constant(1000.0)};  // mm, machine coordinates: what the machine can reach
    double probe_feed_mm_per_s = 0.0;                               // what probing may have, for the account; 0: it does not look
    // mm: the probe closes up to so far before or behind S, along the way; every move that a contact ends draws anew. One that closed
    // before S opens as soon as it moves away.
    double touch_noise_mm = 0.0;
    std::uint64_t touch_noise_seed = 1;
    // Besides, by the time that passes for the tool. It really is where they put it; what the machine says does not know of them. A trigger
    // that is read late brakes late, too. The probe is closed while it is pressed farther than its pre-travel. Misses and bounces are of
    // these where shares of them are given, not of the calls below.
    ProbeErrors errors{};
    // Told of every move that has ended: the way that was gone, in the obstacle's coordinates, and whether the probe closed on it. Errors
    // may bend a way (backlash): then of each straight part.
    std::function<void(const Segment&, bool)> on_move{};
};

// What the machine itself saw, whatever the driver thinks (devices/FACTS.md, "Safety floor").
struct VirtualToolAudit {
    std::uint64_t moves = 0;
    std::uint64_t unguarded_moves = 0;  // moves of any length that no contact would have ended
    std::uint64_t outside_limits = 0;   // moves that ended outside the limits, by more than the resolution
    // Moves that went deeper into the solid than the probe gives way; and those that no contact would have ended and that entered it, or
    // went deeper than they started. Coming out of the solid after a touch is safe. Less than the resolution does not count, nor does
    // less than the backlash where a move begins inside.
    std::uint64_t unsafe_moves = 0;
    // Moves of any guard that went deeper than the probe gives way, as above, and were commanded faster than probing may be.
    std::uint64_t fast_moves_inside = 0;
    double deepest_mm = 0.0;      // into the solid, past a trigger
    double deepest_end_mm = 0.0;  // mm: the deepest place inside where a move ended
    double distance_mm = 0.0;
};

// Movable, not copyable. Time passes only when told. Positions are machine coordinates by the count of steps, rounded to the resolution
// where they are told.
class VirtualTool {
public:
    enum class Guard {
        none,           // ends at the target: G0, G1, a jog
        until_contact,  // slows down when the probe closes, at once if it is closed: G38.2, G38.3
        until_release,  // ends when the probe opens: G38.4, G38.5
    };

    // `obstacle` must outlive the tool.
    VirtualTool(const Obstacle& obstacle, const VirtualToolOptions& options);
    ~VirtualTool();
    VirtualTool(VirtualTool&&) noexcept;

    // Begins a straight move. A move of no length has ended already. REQUIRES: not moving, feed > 0.
    void start_move(const Point& target, double feed_mm_per_s, Guard guard);
    // Slows down now and stays; hold() of a machine.
    void decelerate();
    // Of the move under way, from now on; one that slows down to stop goes on doing so. REQUIRES: feed > 0.
    void change_feed(double feed_mm_per_s);
    // Stops counting steps: a reset. If it was moving, the mass runs on uncounted, as far as braking takes: the position is lost.
    void abort();
    void advance(Seconds time);
    // Until the move has ended; how long that took.
    Seconds finish();
    // By hand or by a homing cycle: it is there now, and the count is right but for drift. Not a move of the account. REQUIRES: not moving.
    void place(const Point& position);
    // Power was off: from now on the count of steps says `position`, wherever the tool is. REQUIRES: not moving.
    void count_from(const Point& position);

    [[nodiscard]] bool is_moving() const { return motion_ != nullptr; }
    [[nodiscard]] Point position() const;
    [[nodiscard]] Point true_position() const;  // where the tool really is; differs after lost steps; not rounded
    [[nodiscard]] double speed_mm_per_s() const;
    [[nodiscard]] bool is_probe_closed() const;
    // Where the probe changed during the last guarded move, whatever way the tool needed to stop: exactly where it did, by the steps, or
    // where it was when that was read (ProbeErrors::latency).
    [[nodiscard]] std::optional<Point> trigger() const;
    // Until something happens by itself: the move ends, the probe changes. Nothing if nothing will.
    [[nodiscard]] std::optional<Seconds> time_to_event() const;

    // Faults: the probe closes for a moment / does not close at the next touch / its lead is cut, so that it reads open / it bounces so
    // often at every touch and release from now on.
    void trigger_spuriously();
    void miss_next_trigger();
    // Of the touches from now on that share, 0 to 1, does not close the probe either; the same ones for the same seed.
    void set_miss_share(double share, std::uint64_t seed);
    void set_unplugged(bool unplugged);
    // Somebody holds the probe closed by hand, wherever the tool is, or lets go of it.
    void press(bool pressed);
    void bounce(int times);

    // Of moves that have ended.
    [[nodiscard]] const VirtualToolAudit& audit() const { return audit_; }
    [[nodiscard]] const VirtualToolOptions& options() const { return options_; }

private:
    [[nodiscard]] std::optional<Seconds> next_event() const;
    void handle_events();
    void watch(double distance);
    void watch_now();
    void end_motion(double distance);
    void record(const ToolMotion& motion, double distance);
    void tell(const ToolMotion& motion, double distance) const;
    [[nodiscard]] bool is_too_deep(double depth) const;
    [[nodiscard]] bool is_fast(const ToolMotion& motion) const;
    [[nodiscard]] bool is_unsafe(const ToolMotion& motion, double distance, double deepest) const;
    [[nodiscard]] Point rounded(const Point& p) const;
    [[nodiscard]] double draw_noise();
    [[nodiscard]] Vector drift() const;
    // mm: where the tool is, less what the steps say, by errors.
    [[nodiscard]] Vector shift() const;
    // mm: what the controller counts on the way to `target` (machine coordinates), and where the tool goes meanwhile.
    [[nodiscard]] Vector steps_to(const Point& target) const;
    [[nodiscard]] std::vector<Leg> legs_along(const Vector& steps, const Point& target) const;
    void draw_errors();
    [[nodiscard]] bool is_pressed_open() const;
    // mm: so far behind the place where the way enters the solid the probe closes; so far before it comes out it opens.
    [[nodiscard]] double lateness();
    [[nodiscard]] double earliness() const;
    // The same before the end of a way on which a tool that is pressed eases and does not come out: there it is pressed no farther than its
    // pre-travel any more. 0 where it is to the end.
    [[nodiscard]] double easing() const;

    const Obstacle& obstacle_;
    VirtualToolOptions options_;
    VirtualToolAudit audit_;
    std::unique_ptr<ProbeInput> input_;
    std::mt19937_64 noise_;
    Seconds now_{0.0};
    Point place_;                            // in the obstacle's coordinates, where the last move ended
    Vector slip_ = Vector::Zero();           // where it really is, less what the steps say, by lost steps
    std::optional<ProbeErrorDraws> errors_;  // if there are any
    Vector play_ = Vector::Zero();           // of the axes (sim/probe/axis_play.h), where the last move ended
    Vector drift_ = Vector::Zero();          // as it was when the last move began
    std::uint64_t touches_ = 0;
    std::unique_ptr<ToolMotion> motion_;
    std::optional<Point> trigger_;  // by the steps, not rounded
};

}  // namespace palpate
