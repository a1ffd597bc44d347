#include "devices/session/datum_device.h"

#include <fmt/format.h>

#include <limits>
#include <utility>

#include "planner/number_text.h"

namespace palpate {
namespace {

using Outcome = MoveResult::Outcome;

// A probe may miss a touch.
constexpr int kTouchAttempts = 2;

}  // namespace

DatumDevice::DatumDevice(JournalingDevice& journal, const Surroundings& surroundings, const MachineSettings& settings)
    : journal_(journal),
      surroundings_(surroundings),
      datum_(settings.datum.value()),
      motion_(settings.motion),
      asked_(journal),
      metered_(asked_, settings.motion),
      frame_{Vector::Zero(), settings.limits},
      log_(datum_),
      way_out_(surroundings, journal.record().header.start) {}

MoveResult DatumDevice::guarded_move(const Point& target, Pace pace) {
    const Point before = asked_.position();
    MoveResult result = asked_.guarded_move(frame_.to_machine(target), pace);
    work_time_ += time_of_move(motion_, before, result, asked_.position(), pace);
    result = frame_.to_part(std::move(result), target);
    last_touch_.reset();
    if (result.outcome == Outcome::contact) {
        ++contacts_;
        last_touch_ = Segment{position(), result.position};
    }
    // Where it was told to go: what the machine's digits make of that is no other place.
    way_out_.add(result.outcome == Outcome::reached ? target : frame_.to_part(asked_.position()));
    return result;
}

bool DatumDevice::is_due() const { return !log_.has_reading() || contacts_ - contacts_at_visit_ >= datum_.every; }

void DatumDevice::prepare(const Point& target) {
    take_up_recorded();
    // A session that is taken up again touches the datum first: then it may not be due any more.
    if (journal_.is_used_up()) journal_.go_live(is_due() ? first_of_visit() : frame_.to_machine(target));
    if (is_due()) visit();
}

void DatumDevice::finish() {
    take_up_recorded();
    if (contacts_ == contacts_at_visit_) return;
    if (journal_.is_used_up()) journal_.go_live(first_of_visit());
    if (contacts_ > contacts_at_visit_) visit();
}

Point DatumDevice::first_of_visit() const {
    if (way_out_.is_outside()) return frame_.to_machine(way_around(surroundings_, position(), datum_.touches.front().from).front());
    return frame_.to_machine(last_touch_ ? last_touch_->source : surroundings_.nearest_entry(position()));
}

void DatumDevice::take_up_recorded() {
    const Journal& record = journal_.record();
    const bool is_at_end = journal_.replayed() == record.moves.size();
    const std::uint64_t next = is_at_end ? std::numeric_limits<std::uint64_t>::max() : record.moves[journal_.replayed()].line;
    for (; taken_up_ < record.resumptions.size() && record.resumptions[taken_up_].line < next; ++taken_up_) {
        take_up(record.resumptions[taken_up_]);
    }
}

void DatumDevice::take_up(const JournalResumption& resumption) {
    if (resumption.datum.empty()) return;
    log_.add(resumption.datum, {contacts_, time()});
    touches_ += resumption.datum.size();
    frame_.shift = log_.shift();
    contacts_at_visit_ = contacts_;
}

void DatumDevice::visit() {
    asked_.mark.emplace();
    const Point place = position();
    // Before the first touch of all nothing has shown that the probe works.
    const Pace pace = log_.has_reading() ? Pace::travel : Pace::probe;
    visiting_ = place;
    const std::vector<Point> out = leave(pace);
    const Point outside = visiting_;
    std::vector<Point> touched;
    VisitTime times;
    const Point last = touch_all(outside, pace, touched, times);
    log_.add(touched, {contacts_, times.middle()});
    frame_.shift = log_.shift();
    contacts_at_visit_ = contacts_;
    const std::vector<Point> back = way_around(surroundings_, last, outside);
    for (std::size_t k = 0; k < back.size(); ++k) go(back[k], k == 0 ? Pace::probe : Pace::travel);
    for (std::size_t k = out.size(); k-- > 1;) go(out[k - 1], Pace::travel);
    go_back_to_work(place);
    asked_.mark.reset();
}

std::vector<Point> DatumDevice::leave(Pace pace) {
    if (way_out_.is_outside()) return {};
    const Point place = visiting_;
    std::vector<Point> passed;
    // A touch is a dead end: back to where the probe began, and straight on from there, away from the part.
    const Point from = last_touch_ ? last_touch_->source : place;
    if (from != place) passed.push_back(from);
    go(from, pace);
    if (way_out_.is_outside(from)) return passed;
    const Vector nearest = surroundings_.nearest_entry(from) - from;
    std::vector<Vector> directions;
    if (last_touch_) directions.emplace_back((from - last_touch_->target).normalized());
    if (!nearest.isZero()) directions.emplace_back(nearest.normalized());
    directions.emplace_back(Vector::UnitZ());
    for (const Vector& direction : directions) {
        if (!leaves_along(direction)) continue;
        // Ways on are shorter from now on.
        const Point exit = visiting_;
        for (const Point& p : {from, exit, from, place}) way_out_.add(p);
        passed.push_back(exit);
        return passed;
    }
    // Where something is in the way of all of these: over ways that were gone.
    go(place, pace);
    passed = way_out_.way();
    for (const Point& p : passed) go(p, pace);
    return passed;
}

bool DatumDevice::leaves_along(const Vector& direction) {
    const Point from = visiting_;
    const auto chord = surroundings_.unknown_part(from, direction);
    if (!chord) return false;
    const Point exit = from + chord->high * direction;
    if (!surroundings_.is_enterable(exit) || surroundings_.first_known({from, exit})) return false;
    const MoveResult result = move_past_sparks(metered_, frame_.to_machine(exit), Pace::probe);
    visiting_ = result.outcome == Outcome::reached ? exit : frame_.to_part(asked_.position());
    if (result.outcome == Outcome::reached) return true;
    go(from, Pace::probe);
    return false;
}

Point DatumDevice::touch_all(Point at, Pace free_pace, std::vector<Point>& touched, VisitTime& times) {
    for (std::size_t k = 0; k < datum_.touches.size(); ++k) {
        const std::vector<Point> way = way_around(surroundings_, at, datum_.touches[k].from);
        // Slowly where something stands outside the workspace: at the datum.
        for (std::size_t leg = 0; leg < way.size(); ++leg)
            go(way[leg], (leg == 0 && k > 0) || leg + 1 == way.size() ? Pace::probe : free_pace);
        touched.push_back(touch(k, times));
        at = datum_.touches[k].from;
    }
    return at;
}

Point DatumDevice::touch(std::size_t k, VisitTime& times) {
    const DatumTouch& touch = datum_.touches[k];
    for (int attempt = 0; attempt < kTouchAttempts; ++attempt) {
        asked_.mark->touch = k;
        const MoveResult result = move_past_sparks(metered_, frame_.to_machine(touch.to), Pace::probe);
        asked_.mark->touch.reset();
        const Seconds touched_at = time();
        visiting_ = frame_.to_part(asked_.position());
        go(touch.from, Pace::probe);
        if (result.outcome != Outcome::contact) continue;
        times.add(touched_at);
        ++touches_;
        return result.position;
    }
    throw DatumFault(
        fmt::format("machine.datum.at[{}]: nothing was touched from {} to {}: the datum is not there any more, or the probe does not close "
                    "any more. Put it back or mend the probe, then resume",
                    k, point_text(touch.from), point_text(touch.to)));
}

void DatumDevice::go(const Point& target, Pace pace) {
    if (visiting_ == target) return;
    const MoveResult result = move_past_sparks(metered_, frame_.to_machine(target), pace);
    visiting_ = result.outcome == Outcome::reached ? target : frame_.to_part(asked_.position());
    if (result.outcome == Outcome::reached) return;
    throw DatumFault(fmt::format(
        "something was touched at {} on the way to the datum or back, on the way to {}: outside the workspace nothing may stand "
        "between it and `from` of machine.datum.at, and nothing in the workspace may move. Look, clear the way, then resume",
        point_text(result.position), point_text(target)));
}

void DatumDevice::go_back_to_work(const Point& place) {
    if (visiting_ == place) return;
    const MoveResult result = move_past_sparks(metered_, frame_.to_machine(place), Pace::travel);
    if (result.outcome != Outcome::reached) {
        const Point touched = frame_.to_part(result.position);
        if ((touched - place).norm() > datum_.limit_mm + motion_.retract_mm) {
            throw DatumFault(
                fmt::format("something was touched at {} on the way back from the datum, where space was free: the part or the "
                            "machine's origin has moved. Look, then resume",
                            point_text(result.position)));
        }
        way_out_.add(frame_.to_part(asked_.position()));
    }
}

}  // namespace palpate
