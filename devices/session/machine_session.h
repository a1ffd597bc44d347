// A session on a machine: started, interrupted, taken up again, or replayed from its journal without a machine.
//
// Any Machine (devices/machine.h) will do:
//
//   SessionHost host;
//   host.connect = [] { return std::make_unique<MyMachine>(…); };
//   host.ask = [](const PlannedMotion& plan) { … };
//   const SessionPlan plan{settings, Region(Ball{…}), options, "part/journal.jsonl", digest(text of all of that), "part.yaml"};
//   const MachineRun run = std::filesystem::exists(plan.journal) ? resume_session(plan, host) : start_session(plan, host);
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "devices/decorators/metered_device.h"
#include "devices/machine.h"
#include "devices/session/journal.h"
#include "devices/session/machine_settings.h"
#include "devices/stop_request.h"
#include "planner/probe_surface.h"

namespace palpate {

// What is probed, with what, how, and where the answers go.
struct SessionPlan {
    MachineSettings machine;
    Surroundings workspace;  // ω, and what is known before anything is asked
    Options probing;
    std::filesystem::path journal;
    std::string config_digest;    // digest() of what the plan was made from: a journal goes on with the plan that it was begun with alone
    std::string config_name;      // what messages call that
    std::string object_sha256{};  // of the file that describes the object, if there is one: the journal keeps it, nothing depends on it
    // The budget is larger than in the plan, of that digest, that the journal goes by: it says so as soon as the operator has agreed.
    std::optional<std::string> raised_from{};
};

// What the operator is asked to agree to.
struct PlannedMotion {
    enum class Kind {
        begin,  // around and into the workspace until it has found the part's shape
        go_on,  // back to where the session ended, to known places again, and on
    };
    Kind kind = Kind::begin;
    MachineReport report;                 // the machine as it is now
    bool homes_first = false;             // unguarded, from where it is
    std::optional<Point> first_target{};  // of the first move, if nothing has to happen before that is known
    Pace first_pace = Pace::travel;
};

// Whoever runs a session.
struct SessionHost {
    std::function<std::unique_ptr<Machine>()> connect;  // a replay needs none; what it gives heeds `stop` by itself
    std::function<void(const PlannedMotion&)> ask;      // asks the operator before anything moves; throws if the answer is no
    std::function<void(const Progress&, const RunView&)> on_progress = {};  // may be empty
    std::function<void()> on_raised = {};  // the journal goes by the plan with the larger budget from now on; may be empty
    std::function<void(const std::string& sentence)> say = [](const std::string&) {};  // what the operator may want to know
    // Has the probe pressed by hand, and says whether it was seen to close and to open; empty: nobody can be asked.
    std::function<bool(Machine&)> press = {};
    StopToken stop = {};
    // Returns once a pause that `stop` asks for is over; nothing moves meanwhile. Empty: nobody asks for one.
    std::function<void()> pause = {};
};

// What visits to the datum (machine.datum) found, and what they took.
struct DriftAccount {
    std::size_t visits = 0;
    std::uint64_t touches = 0;       // of the datum, besides those of the part
    double way_mm = 0.0;             // there, back, and for these touches, besides that of the meter
    int directions = 0;              // 0 to 3: in which a shift was seen
    Vector shift = Vector::Zero();   // mm: of the part, at the last visit, since the first
    double largest_shift_mm = 0.0;   // since the first visit
    double largest_change_mm = 0.0;  // from one visit to the next
};

struct MachineRun {
    Result result;
    Meter meter;               // of the answers that the planner got, replayed ones too
    std::uint64_t grazes = 0;  // touches on travel that were passed beside
    std::vector<JournalResumption> resumptions;
    std::optional<DriftAccount> drift;  // with a datum only
    std::string machine;                // identity
    std::string object_sha256;          // as the journal has it
    double planner_seconds = 0.0;
    double oracle_seconds = 0.0;
};

// A replay of a session that has not come to its end.
class NotFinished : public SetupError {
public:
    using SetupError::SetupError;
};

// Throws SetupError if the session was not begun with that plan.
void check_plan(const Journal& journal, const SessionPlan& plan);
// Throws SetupError if the tool may not go all around ω, or as check_datum() does, std::invalid_argument as check_options does. All of the
// below begin with it.
void check_session(const MachineSettings& machine, const Surroundings& workspace, const Options& probing);

// Throws SetupError if a session cannot begin with the tool there: it is outside `limits`, or where no way is known to be free.
void check_start(const Surroundings& surroundings, const Box& limits, const Point& start);

// A new session; makes its journal. Throws DeviceError on a fault, after which the session can be resumed if the journal was begun,
// SetupError if the tool is where it cannot begin, std::invalid_argument if the probe is to be pressed by hand and nobody can be asked, and
// what probe_surface throws.
[[nodiscard]] MachineRun start_session(const SessionPlan& plan, const SessionHost& host);
// Takes up a session where its journal ends: replays it, brings the tool back, touches known places again, and goes on. What was found free
// since the last contact is asked again. One that is finished is replayed. Throws besides SetupError if the plan is another one.
[[nodiscard]] MachineRun resume_session(const SessionPlan& plan, const SessionHost& host);
// The same result again, from the journal of a session that was finished. Throws besides NotFinished.
[[nodiscard]] MachineRun replay_session(const SessionPlan& plan, const SessionHost& host);

// How often known places were touched again because a probe had missed a touch.
[[nodiscard]] std::size_t missed_touches(const std::vector<JournalResumption>& resumptions);

}  // namespace palpate
