// What is above sees the part's frame; below, the machine drifts, and the datum is touched again now and then (devices/README.md, "Drift").
//
// It stands above the journal, which so has what the machine said, the visits too; a replay asks for the same again. A visit goes out of
// the workspace over ways that the tool has gone, around it to the datum, and back to where the tool was: whoever is above does not notice.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "devices/decorators/metered_device.h"
#include "devices/session/drift_log.h"
#include "devices/session/journaling_device.h"
#include "devices/session/machine_settings.h"
#include "devices/session/part_frame.h"
#include "devices/session/way_out.h"

namespace palpate {

class DatumDevice final : public ProbeDevice {
public:
    // `journal` and `surroundings` must outlive this. REQUIRES: settings.datum, for which check_datum() has nothing to say; an answer of
    // the journal is asked for by nobody else.
    DatumDevice(JournalingDevice& journal, const Surroundings& surroundings, const MachineSettings& settings);

    [[nodiscard]] Point position() const override { return way_out_.place(); }
    // Visits nothing by itself.
    [[nodiscard]] MoveResult guarded_move(const Point& target, Pace pace) override;
    void stop() override { journal_.stop(); }

    // Before a move to `target`, where nothing is under way: visits the datum if that is due. Throws DatumFault, and what moves throw.
    void prepare(const Point& target);
    // After the last move: once more, so that what was touched since the last visit lies between two.
    void finish();
    // What was found when the session was taken up again. Throws DriftJump.
    void take_up(const JournalResumption& resumption);

    [[nodiscard]] const DriftLog& log() const { return log_; }
    // That a machine takes for all moves until now, visits included.
    [[nodiscard]] Seconds time() const { return work_time_ + visits().machine_time; }
    [[nodiscard]] const Meter& visits() const { return metered_.meter(); }
    [[nodiscard]] std::uint64_t touches() const { return touches_; }  // of the datum

private:
    // The journal. Where the tool is, is where its last move left it: a tool that was brought back there may be beside it by the last
    // digit, which a replay does not know.
    class Asked final : public ProbeDevice {
    public:
        explicit Asked(JournalingDevice& journal) : journal_(journal), rest_(journal.record().header.start) {}

        [[nodiscard]] Point position() const override { return rest_; }
        [[nodiscard]] MoveResult guarded_move(const Point& target, Pace pace) override {
            MoveResult result = mark ? journal_.datum_move(target, pace, *mark) : journal_.guarded_move(target, pace);
            rest_ = journal_.position();
            return result;
        }
        void stop() override { journal_.stop(); }

        std::optional<DatumMark> mark{};  // of moves that are part of a visit

    private:
        JournalingDevice& journal_;
        Point rest_;
    };

    [[nodiscard]] bool is_due() const;
    // The machine's: where a visit goes first.
    [[nodiscard]] Point first_of_visit() const;
    void take_up_recorded();
    void visit();
    // Out of the workspace; the points that were passed, up to and with one outside or on the boundary. None: the tool is at one.
    std::vector<Point> leave(Pace pace);
    // Straight and guarded; false if something is in the way, and the tool is back.
    [[nodiscard]] bool leaves_along(const Vector& direction);
    // Touches the datum, from a place outside; returns where the tool is then: at the start of the last touch.
    Point touch_all(Point at, Pace free_pace, std::vector<Point>& touched, VisitTime& times);
    Point touch(std::size_t k, VisitTime& times);
    // Throws DatumFault if something is in the way.
    void go(const Point& target, Pace pace);
    // There the part may be nearer than it was.
    void go_back_to_work(const Point& place);

    JournalingDevice& journal_;
    const Surroundings& surroundings_;
    const DriftDatum datum_;
    const MotionModel motion_;
    Asked asked_;
    MeteredDevice metered_;
    PartFrame frame_;
    DriftLog log_;
    WayOut way_out_;
    Point visiting_ = Point::Zero();  // where the tool is while it is on a visit
    std::uint64_t touches_ = 0;
    std::uint64_t contacts_ = 0;  // touches of the part
    std::uint64_t contacts_at_visit_ = 0;
    Seconds work_time_{0.0};  // of all other moves
    // The last touch of the part: from where, and where; the tool rests between.
    std::optional<Segment> last_touch_{};
    std::size_t taken_up_ = 0;  // resumptions of the record that were heard of
};

}  // namespace palpate
