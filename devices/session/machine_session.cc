#include "devices/session/machine_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "devices/decorators/slow_device.h"
#include "devices/device_oracle.h"
#include "devices/errors.h"
#include "devices/session/datum_oracle.h"
#include "devices/session/journaling_device.h"
#include "devices/session/resumption.h"
#include "devices/timed_oracle.h"
#include "devices/version.h"
#include "planner/errors.h"
#include "planner/number_text.h"
#include "planner/surroundings.h"

namespace palpate {
namespace {

DriftAccount account_of(const DatumDevice& datum) {
    const DriftLog& log = datum.log();
    return {log.visits(), datum.touches(),        datum.visits().displacement_mm, log.directions(),
            log.shift(),  log.largest_shift_mm(), log.largest_change_mm()};
}

// What the planner makes of the answers of `journal`, of which `datum` may be above it. `press` asks for the probe to be pressed by hand.
MachineRun run_on(JournalingDevice& journal, DatumDevice* datum, const SessionPlan& plan, const SessionHost& host,
                  const std::function<bool()>& press) {
    MeteredDevice metered(datum != nullptr ? static_cast<ProbeDevice&>(*datum) : journal, plan.machine.motion);
    // What the session went on after was shown to work.
    OracleTraits traits = plan.machine.traits();
    traits.overtravel = plan.machine.motion.overtravel_mm;
    DeviceOracle device_oracle(metered, traits, DeviceOracle::Positions::as_traits_say, [&] { return !journal.is_used_up() || press(); });
    std::optional<DatumOracle> datum_oracle;
    if (datum != nullptr) datum_oracle.emplace(device_oracle, *datum);
    TimedOracle oracle(datum_oracle ? static_cast<SurfaceOracle&>(*datum_oracle) : device_oracle);
    Options options = plan.probing;
    options.goes_home = true;
    Observer observer;
    observer.on_progress = host.on_progress;
    observer.on_home = [&](double way_mm) {
        if (!journal.is_used_up()) return;
        host.say(
            fmt::format("the last touch is made; the tool goes back, straight out of the workspace and around it to where it began: {} mm",
                        number_text(std::round(way_mm))));
    };
    MachineRun run;
    const auto begin = std::chrono::steady_clock::now();
    run.result = probe_surface(oracle, plan.workspace, options, observer);
    if (datum_oracle) {
        datum->finish();
        datum_oracle->take_out_drift(run.result);
        run.drift = account_of(*datum);
    }
    const Seconds total = std::chrono::steady_clock::now() - begin;
    run.oracle_seconds = oracle.spent().count();
    run.planner_seconds = (total - oracle.spent()).count();
    run.meter = metered.meter();
    if (datum != nullptr) run.meter.machine_time += datum->visits().machine_time;
    run.grazes = device_oracle.grazes();
    run.machine = journal.record().header.machine;
    run.object_sha256 = journal.record().header.object_sha256;
    return run;
}

// A device that is only asked where it would go first.
class Asked final : public ProbeDevice {
public:
    explicit Asked(const Point& start) : start_(start) {}

    struct Move {
        Point target;
        Pace pace;
    };
    [[nodiscard]] Point position() const override { return start_; }
    [[nodiscard]] MoveResult guarded_move(const Point& target, Pace pace) override { throw Move{target, pace}; }
    void stop() override {}

private:
    Point start_;
};

std::pair<Point, Pace> first_move(const SessionPlan& plan, const Point& start) {
    if (plan.machine.datum) {
        for (const Point& p : way_around(plan.workspace, start, plan.machine.datum->touches.front().from))
            if (p != start) return {p, Pace::probe};
    }
    Asked asked(start);
    DeviceOracle oracle(asked, plan.machine.traits(), DeviceOracle::Positions::as_traits_say);
    try {
        (void)probe_surface(oracle, plan.workspace, plan.probing);
    } catch (const Asked::Move& move) {
        return {move.target, move.pace};
    }
    return {start, Pace::travel};
}

// A shift along these directions would not have been seen.
void warn_of_blind_directions(const JournalResumption& found, const SessionHost& host) {
    if (found.directions >= 3) return;
    if (found.contacts.empty()) {
        return host.say("nothing was touched yet, so nothing shows whether part and machine are where they were: look");
    }
    host.say(
        fmt::format("{} known place(s) were touched again, which show a shift of the part or the machine in {} of 3 directions only: look "
                    "whether both are where they were",
                    found.contacts.size(), found.directions));
}

// The journal is shorter than what the session takes it for: it is read again.
struct ReadAgain {};

bool is_pressed_by_hand(const SessionPlan& plan, const SessionHost& host) {
    return plan.machine.probe_proof != ProbeProof::first_touch && host.press;
}

// A session with its journal: runs the planner on it, again and again where part of the journal is not to be believed.
class Session {
public:
    Session(const SessionPlan& plan, const SessionHost& host, JournalWriter& writer) : plan_(plan), host_(host), writer_(writer) {}

    // `guarded` is the machine if it is connected already, with the tool where the journal ends.
    MachineRun run(GuardedMachine* guarded = nullptr) {
        guarded_ = guarded;
        while (true) {
            record_ = writer_.read();
            if (record_.end && !plan_.raised_from) {
                host_.say("this session is finished; its files are made again from its journal");
                return replay_session(plan_, host_);
            }
            check_plan(record_, plan_);
            if ((plan_.raised_from && !has_raised_) || (record_.is_raised_last && record_.confirmed_moves() < record_.moves.size())) {
                // What it did at its end, going home, is not what it does now.
                try {
                    return_to({record_.last_rest(), record_.confirmed_moves(), {}}, false);
                } catch (const ReadAgain&) {
                    continue;
                }
            }
            if (record_.dropped_bytes > 0) host_.say("the last line of the journal was torn and is dropped: that move is made again");
            try {
                return run_once();
            } catch (const ReadAgain&) {
                continue;
            }
        }
    }

private:
    MachineRun run_once() {
        std::optional<DatumDevice> datum;
        JournalingDevice journal(
            record_, &writer_,
            [&](const Point& next_target) -> ProbeDevice& {
                if (guarded_ == nullptr) {
                    return_to({next_target, record_.confirmed_moves(), {}}, false);
                    if (datum) datum->take_up(record_.resumptions.back());
                }
                return device();
            },
            host_.stop, host_.pause);
        if (plan_.machine.datum) datum.emplace(journal, plan_.workspace, plan_.machine);
        try {
            MachineRun run = run_on(journal, datum ? &*datum : nullptr, plan_, host_, [&] {
                return guarded_ != nullptr && is_pressed_by_hand(plan_, host_) && host_.press(guarded_->machine());
            });
            run.resumptions = record_.resumptions;
            writer_.append(JournalEnd{run.planner_seconds, run.oracle_seconds});
            return run;
        } catch (const SilenceError& error) {
            // What came after the last contact is asked again; if that is nothing, there is nothing to ask.
            if (journal.is_live() || record_.confirmed_moves() == record_.moves.size()) throw DeviceError(error.what());
            host_.say(fmt::format("the session had stopped: {}", error.what()));
            return_to({record_.last_rest(), record_.confirmed_moves(), {}}, false);
        } catch (const DatumFault& fault) {
            if (journal.is_live()) throw;
            host_.say(fmt::format("the session had stopped: {}", fault.what()));
            const bool has_jumped = dynamic_cast<const DriftJump*>(&fault) != nullptr;
            const std::size_t moves =
                has_jumped ? read_drift(record_, plan_.machine.datum.value(), plan_.machine.motion).moves : record_.confirmed_moves();
            return_to({record_.last_rest(), moves, {}}, false);
        } catch (const UnexpectedContact& contact) {
            if (journal.is_live()) record_ = writer_.read();
            settle(contact, journal);
        }
        throw ReadAgain{};
    }

    // Space was free and is touched. If a probe found it free, and known places show that neither part nor machine moved, that probe missed
    // S: from there on the session is made again. If not, a session that halted so is asked again once.
    void settle(const UnexpectedContact& contact, JournalingDevice& journal) {
        const std::size_t count = record_.moves.size();
        if (contact.moves() == 0 || contact.moves() > count) throw contact;  // it was not the planner's travel
        const double tolerance = 2 * DeviceOracle::kGraze * plan_.machine.touch_error();
        const std::size_t before = count - contact.moves();
        const auto missed = in_part_frame_of(record_).last_passed(contact.where(), tolerance, before);
        if (missed && missed_touches(record_.resumptions) < kMisses + count / kMovesPerMiss) {
            host_.say(fmt::format("{}. A probe had passed there and found nothing; known places are touched again", contact.what()));
            return_to({record_.last_rest(), *missed, VisitedWays::Contradiction{contact.where(), tolerance, *missed, before}}, true);
        }
        if (journal.is_live() || asked_again_) throw contact;
        asked_again_ = true;
        host_.say(fmt::format("the session had halted: {}; that way is gone again", contact.what()));
        journal.withdraw(contact.moves());
    }

    // As the planner has it.
    [[nodiscard]] Journal in_part_frame_of(const Journal& journal) const {
        if (!plan_.machine.datum) return journal;
        return in_part_frame(journal, read_drift(journal, *plan_.machine.datum, plan_.machine.motion));
    }

    // The machine that is connected.
    ProbeDevice& device() {
        if (missed_touches(record_.resumptions) == 0) return guarded_->device();
        return slow_.emplace(guarded_->device());
    }

    // Connects, if that is not done, touches known places again, and brings the tool to where what is to be believed ends. Nothing but a
    // contact shows that the probe worked: what came after the last one is asked again.
    void return_to(const Interruption& interruption, bool after_miss) {
        if (guarded_ == nullptr) {
            own_.emplace(host_.connect(), plan_.machine, host_.stop, host_.pause);
            guarded_ = &*own_;
            const MachineReport report = guarded_->machine().report();
            host_.ask({PlannedMotion::Kind::go_on, report, plan_.machine.homes_first(report)});
            raise_budget();
        }
        auto [found, moves] = return_to_work(*guarded_, record_, plan_.workspace, plan_.machine, interruption);
        found.after_miss = after_miss;
        warn_of_blind_directions(found, host_);
        if (moves < record_.moves.size()) writer_.append_withdrawn(record_.moves[moves].line);
        found.line = writer_.append(found);
        if (moves < record_.moves.size()) throw ReadAgain{};
        record_.resumptions.push_back(found);
    }

    void raise_budget() {
        if (!plan_.raised_from || has_raised_) return;
        writer_.append_raised(plan_.config_digest);
        has_raised_ = true;
        if (host_.on_raised) host_.on_raised();
    }

    // A probe that misses more than so many touches, and one in so many moves, is to be looked at.
    static constexpr std::size_t kMisses = 5;
    static constexpr std::size_t kMovesPerMiss = 40;

    const SessionPlan& plan_;
    const SessionHost& host_;
    JournalWriter& writer_;
    Journal record_;
    std::optional<GuardedMachine> own_;
    GuardedMachine* guarded_ = nullptr;
    std::optional<SlowDevice> slow_;
    bool asked_again_ = false;
    bool has_raised_ = false;
};

}  // namespace

void check_start(const Surroundings& surroundings, const Box& limits, const Point& start) {
    if (!limits.contains(start)) {
        throw SetupError(fmt::format("the tool is at {}, outside machine.limits, {} to {}: move it inside them by hand, then start again",
                                     point_text(start), point_text(limits.min), point_text(limits.max)));
    }
    if (surroundings.known().is_barred(start)) {
        throw SetupError(
            fmt::format("the tool is at {}, below a table or behind a half-space of workspace.fixtures{}: check these, or move it out",
                        point_text(start), surroundings.area() ? ", or beside probing.area" : ""));
    }
    if (surroundings.is_free(start)) return (void)surroundings.nearest_entry(start);
    throw SetupError(
        fmt::format("the tool is inside the workspace, at {}, where no way is known to be free: move it outside by hand, then start again",
                    point_text(start)));
}

// The configuration decides what the planner asks: another one would not fit the journal.
void check_plan(const Journal& journal, const SessionPlan& plan) {
    if (journal.fits(plan.raised_from.value_or(plan.config_digest))) return;
    throw SetupError(fmt::format(
        "{}: was changed since the session began, and its journal does not fit it any more: put the old one back, or begin a new session",
        plan.config_name));
}

void check_session(const MachineSettings& machine, const Surroundings& workspace, const Options& probing) {
    const Box around = workspace.bounds();
    const Box& limits = machine.limits;
    if (!limits.contains(around)) {
        throw SetupError(
            fmt::format("machine.limits: the tool has to get all around the workspace, from {} to {}, but the limits are {} to {}: make "
                        "the workspace smaller or the limits wider",
                        point_text(around.min), point_text(around.max), point_text(limits.min), point_text(limits.max)));
    }
    check_datum(machine, workspace);
    check_options(workspace, probing, machine.traits());
}

MachineRun start_session(const SessionPlan& plan, const SessionHost& host) {
    const Box& limits = plan.machine.limits;
    check_session(plan.machine, plan.workspace, plan.probing);
    if (plan.machine.probe_proof == ProbeProof::hand && !host.press) {
        throw std::invalid_argument("the probe is to be pressed by hand before anything moves: SessionHost::press is missing");
    }
    GuardedMachine guarded(host.connect(), plan.machine, host.stop, host.pause);
    Machine& machine = guarded.machine();
    const MachineReport report = machine.report();
    // Homing moves it elsewhere; otherwise nobody need be asked about a session that cannot begin.
    if (machine.is_position_trusted()) check_start(plan.workspace, limits, report.position);
    PlannedMotion planned{PlannedMotion::Kind::begin, report, plan.machine.homes_first(report)};
    if (machine.is_position_trusted()) std::tie(planned.first_target, planned.first_pace) = first_move(plan, report.position);
    host.ask(planned);
    if (is_pressed_by_hand(plan, host) && !host.press(machine)) {
        throw DeviceError(
            "the probe was not seen to close and to open; nothing has moved. Look at its lead, plug and battery; without somebody to press "
            "it: machine.probe_proof: first_touch");
    }
    machine.make_ready();
    const JournalHeader header{plan.config_digest, guarded.device().position(), report.identity, std::string(program_version()),
                               plan.object_sha256};
    check_start(plan.workspace, limits, header.start);
    JournalWriter writer = JournalWriter::create(plan.journal, header);
    return Session(plan, host, writer).run(&guarded);
}

MachineRun replay_session(const SessionPlan& plan, const SessionHost& host) {
    check_session(plan.machine, plan.workspace, plan.probing);
    Journal record = read_journal(plan.journal);
    check_plan(record, plan);
    if (!record.end) throw NotFinished(fmt::format("{}: this session is not finished: resume it", plan.journal.string()));
    const JournalEnd end = *record.end;
    const std::vector<JournalResumption> resumptions = record.resumptions;
    JournalingDevice journal(std::move(record), nullptr, {}, host.stop, host.pause);
    std::optional<DatumDevice> datum;
    if (plan.machine.datum) datum.emplace(journal, plan.workspace, plan.machine);
    MachineRun run = run_on(journal, datum ? &*datum : nullptr, plan, host, [] { return false; });
    run.planner_seconds = end.planner_seconds;
    run.oracle_seconds = end.oracle_seconds;
    run.resumptions = resumptions;
    return run;
}

MachineRun resume_session(const SessionPlan& plan, const SessionHost& host) {
    check_session(plan.machine, plan.workspace, plan.probing);
    JournalWriter writer(plan.journal);
    return Session(plan, host, writer).run();
}

std::size_t missed_touches(const std::vector<JournalResumption>& resumptions) {
    return static_cast<std::size_t>(std::ranges::count_if(resumptions, [](const JournalResumption& r) { return r.after_miss; }));
}

}  // namespace palpate
