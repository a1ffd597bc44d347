#include "devices/session/drift_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <utility>

#include "devices/decorators/metered_device.h"

namespace palpate {

void DriftLog::add(const std::vector<Point>& touched, const JournalTime& when) {
    if (touched.size() != datum_.touches.size() || touched.empty()) {
        throw BadAnswer(
            fmt::format("a visit to the datum has {} touches, machine.datum.at has {}: the configuration is not the one that the "
                        "session was begun with",
                        touched.size(), datum_.touches.size()));
    }
    const bool is_first = !has_reading();
    const std::vector<Point>& first = is_first ? touched : first_;
    std::vector<DatumOffset> offsets;
    for (std::size_t k = 0; k < touched.size(); ++k) {
        const Vector normal = -datum_.touches[k].inwards();
        offsets.push_back({normal, normal.dot(touched[k] - first[k])});
    }
    const SeenShift seen = seen_shift_of(offsets);
    const double change = (seen.shift - shift_).norm();
    const double now = when.time.count();
    if (!is_first && change > datum_.limit_mm) {
        throw DriftJump(fmt::format(
            "the datum is {:.4f} mm from where the visit before found it, {} touches ago, more than machine.datum.limit, {:g} mm: the "
            "part, "
            "the datum, the probe or the axes have moved. What was touched since cannot be corrected: put back or fasten what moved, then "
            "resume, and it is touched again. If all that drifts, begin a new session with a smaller machine.datum.every",
            change, when.contacts - std::min(contacts_, when.contacts), datum_.limit_mm));
    }
    if (is_first) first_ = touched;
    contacts_ = when.contacts;
    if (!is_first && readings_.back().at >= now) {
        readings_.back().shift = seen.shift;
    } else {
        readings_.push_back({now, seen.shift});
    }
    shift_ = seen.shift;
    directions_ = seen.directions;
    ++visits_;
    largest_shift_ = std::max(largest_shift_, shift_.norm());
    largest_change_ = std::max(largest_change_, change);
}

DriftRecord read_drift(const Journal& journal, const DriftDatum& datum, const MotionModel& motion) {
    DriftRecord record{DriftLog(datum)};
    JournalTime now;
    std::vector<Point> visit;
    VisitTime visit_time;
    auto resumption = journal.resumptions.begin();
    const auto add = [&](const std::vector<Point>& touched, Seconds time, std::size_t moves) {
        try {
            record.log.add(touched, {now.contacts, time});
            record.moves = moves;
            return true;
        } catch (const DriftJump&) {
            return false;  // whoever made it knows
        }
    };
    const auto take_up = [&](std::uint64_t before_line, std::size_t moves) {
        for (; resumption != journal.resumptions.end() && resumption->line < before_line; ++resumption) {
            if (!resumption->datum.empty()) (void)add(resumption->datum, now.time, moves);
        }
    };
    bool is_on_way_back = false;
    for (std::size_t k = 0; k < journal.moves.size(); ++k) {
        const JournalMove& move = journal.moves[k];
        take_up(move.line, k);
        record.shifts.push_back(record.log.shift());
        now.time += time_of_move(motion, journal.rest_before(k), move.result, move.rest, move.pace);
        const bool is_contact = move.result.outcome == MoveResult::Outcome::contact;
        if (!move.datum) {
            is_on_way_back = false;
            if (is_contact) ++now.contacts;
        } else if (move.datum->touch && is_contact) {
            if (*move.datum->touch == 0) {
                visit.clear();
                visit_time = {};
            }
            visit.push_back(move.result.position);
            visit_time.add(now.time);
        } else if (!visit.empty() && visit.size() == datum.touches.size()) {
            // The way back: the visit counts once the tool is off the datum.
            is_on_way_back = add(std::exchange(visit, {}), visit_time.middle(), k + 1);
        } else if (is_on_way_back) {
            record.moves = k + 1;
        }
        record.after.push_back(now);
    }
    record.end = now;
    take_up(journal.lines, journal.moves.size());
    return record;
}

Journal in_part_frame(Journal journal, const DriftRecord& drift) {
    assert(journal.moves.size() == drift.shifts.size());
    for (std::size_t k = 0; k < journal.moves.size(); ++k) {
        JournalMove& move = journal.moves[k];
        const Vector& shift = drift.shifts[k];
        const bool is_touch = !move.datum && move.result.outcome == MoveResult::Outcome::contact;
        move.target -= shift;
        move.rest -= shift;
        move.result.position -= is_touch ? drift.log.at(drift.after[k].time) : shift;
        for (DeviceEvent& event : move.result.events) event.position -= shift;
    }
    return journal;
}

}  // namespace palpate
