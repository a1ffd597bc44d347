#include "devices/session/journaling_device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "devices/session/visited_ways.h"
#include "tests/random.h"

namespace palpate::journaling_device_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

// Touches the plane z = 0 from above and rests 0.5 before it.
class FloorDevice final : public ProbeDevice {
public:
    explicit FloorDevice(const Point& start) : position_(start) {}
    [[nodiscard]] Point position() const override { return position_; }
    [[nodiscard]] MoveResult guarded_move(const Point& target, Pace /*pace*/) override {
        if (fails) throw DeviceError("cable pulled");
        ++moves;
        if (target.z() > 0) {
            position_ = target;
            return {MoveResult::Outcome::reached, target};
        }
        const Point start = position_;
        const Point touched = start + start.z() / (start.z() - target.z()) * (target - start);
        position_ = touched + std::min(0.5 / (start - touched).norm(), 1.0) * (start - touched);
        return {MoveResult::Outcome::contact, touched, {{DeviceEvent::Kind::spurious_trigger, start}}};
    }
    void stop() override { ++stops; }

    bool fails = false;
    int moves = 0;
    int stops = 0;

private:
    Point position_;
};

class Journaling : public ::testing::Test {
protected:
    Journaling() {
        std::string name = (fs::temp_directory_path() / "palpate_journaling_XXXXXX").string();
        folder_ = mkdtemp(name.data());
        file_ = folder_ / "journal.jsonl";
    }
    ~Journaling() override { fs::remove_all(folder_); }

    fs::path folder_;
    fs::path file_;
    const JournalHeader header_{"c", {0, 0, 10}, "floor"};
    const std::vector<std::pair<Point, Pace>> requests_ = {{{1, 0, 9}, Pace::travel}, {{1, 0, -3}, Pace::probe}, {{1, 0, 5}, Pace::travel},
                                                           {{4, 0, 5}, Pace::travel}, {{4, 0, -1}, Pace::probe}, {{4, 0, 5}, Pace::travel}};
};

TEST_F(Journaling, AnAnswerIsOnTheDiskBeforeItIsGiven) {
    FloorDevice floor(header_.start);
    JournalWriter writer = JournalWriter::create(file_, header_);
    JournalingDevice device(Journal{header_}, &writer, [&](const Point&) -> ProbeDevice& { return floor; });
    EXPECT_EQ(device.position(), header_.start);
    for (std::size_t k = 0; k < requests_.size(); ++k) {
        const MoveResult result = device.guarded_move(requests_[k].first, requests_[k].second);
        const Journal journal = read_journal(file_);
        ASSERT_EQ(journal.moves.size(), k + 1);
        EXPECT_EQ(journal.moves[k].result, result);
        EXPECT_EQ(journal.moves[k].rest, floor.position());
        EXPECT_EQ(device.position(), floor.position());
    }
    device.stop();
    EXPECT_EQ(floor.stops, 1);
}

TEST_F(Journaling, AFaultLeavesNoLine) {
    FloorDevice floor(header_.start);
    JournalWriter writer = JournalWriter::create(file_, header_);
    JournalingDevice device(Journal{header_}, &writer, [&](const Point&) -> ProbeDevice& { return floor; });
    (void)device.guarded_move({1, 0, 9}, Pace::travel);
    floor.fails = true;
    EXPECT_THROW((void)device.guarded_move({2, 0, 9}, Pace::travel), DeviceError);
    EXPECT_EQ(read_journal(file_).moves.size(), 1U);
}

TEST_F(Journaling, TheRecordAnswersFirstAndGoesLiveWhereItEnds) {
    for (std::size_t split = 0; split <= requests_.size(); ++split) {
        fs::remove(file_);
        std::vector<MoveResult> answers;
        {
            FloorDevice floor(header_.start);
            JournalWriter writer = JournalWriter::create(file_, header_);
            JournalingDevice device(Journal{header_}, &writer, [&](const Point&) -> ProbeDevice& { return floor; });
            for (std::size_t k = 0; k < split; ++k) answers.push_back(device.guarded_move(requests_[k].first, requests_[k].second));
        }
        JournalWriter writer(file_);
        Journal record = writer.read();
        FloorDevice floor(record.last_rest());
        std::vector<Point> went_live;
        JournalingDevice device(std::move(record), &writer, [&](const Point& target) -> ProbeDevice& {
            went_live.push_back(target);
            return floor;
        });
        for (std::size_t k = 0; k < requests_.size(); ++k) {
            const MoveResult answer = device.guarded_move(requests_[k].first, requests_[k].second);
            if (k < split) {
                EXPECT_EQ(answer, answers[k]);
                EXPECT_FALSE(device.is_live());
            }
        }
        EXPECT_EQ(went_live.size(), split < requests_.size() ? 1U : 0U);
        if (split < requests_.size()) {
            EXPECT_EQ(went_live[0], requests_[split].first);
        }
        EXPECT_EQ(static_cast<std::size_t>(floor.moves), requests_.size() - split) << "nothing is asked twice";
        EXPECT_EQ(read_journal(file_).moves.size(), requests_.size());
    }
}

TEST_F(Journaling, AnotherRequestThanTheRecordedOneIsAnErrorThatSaysWhere) {
    FloorDevice floor(header_.start);
    JournalWriter writer = JournalWriter::create(file_, header_);
    JournalingDevice first(Journal{header_}, &writer, [&](const Point&) -> ProbeDevice& { return floor; });
    for (const auto& [target, pace] : requests_) (void)first.guarded_move(target, pace);
    for (const bool other_pace : {false, true}) {
        JournalingDevice again(read_journal(file_), nullptr, {});
        (void)again.guarded_move(requests_[0].first, requests_[0].second);
        try {
            (void)again.guarded_move(other_pace ? requests_[1].first : Point(1, 0, std::nextafter(-3, 0)),
                                     other_pace ? Pace::travel : Pace::probe);
            FAIL();
        } catch (const ReplayMismatch& mismatch) {
            EXPECT_THAT(mismatch.what(), HasSubstr("line 3"));
        }
    }
}

TEST_F(Journaling, TheOperatorIsHeardInAReplay) {
    FloorDevice floor(header_.start);
    JournalWriter writer = JournalWriter::create(file_, header_);
    JournalingDevice first(Journal{header_}, &writer, [&](const Point&) -> ProbeDevice& { return floor; });
    for (const auto& [target, pace] : requests_) (void)first.guarded_move(target, pace);
    StopSource stop;
    JournalingDevice again(writer.read(), nullptr, {}, stop.token());
    (void)again.guarded_move(requests_[0].first, requests_[0].second);
    stop.request_stop();
    EXPECT_THROW((void)again.guarded_move(requests_[1].first, requests_[1].second), Stopped);
}

TEST_F(Journaling, AMachineThatCannotBeBroughtBackIsNoPartOfTheRecord) {
    JournalWriter writer = JournalWriter::create(file_, header_);
    JournalingDevice device(Journal{header_}, &writer, [](const Point&) -> ProbeDevice& {
        throw UnexpectedContact({0, 0, 1}, "the way back");
    });
    EXPECT_THROW((void)device.guarded_move({1, 0, 9}, Pace::travel), UnexpectedContact);
    EXPECT_TRUE(device.is_live()) << "so that nobody takes it for a recorded touch";
    EXPECT_TRUE(read_journal(file_).moves.empty());
}

TEST_F(Journaling, WithoutAMachineTheRecordHasToSuffice) {
    Journal record{header_};
    record.lines = 1;
    JournalingDevice device(record, nullptr, {});
    EXPECT_THROW((void)device.guarded_move({1, 0, 9}, Pace::travel), ReplayMismatch);
}

TEST_F(Journaling, AWithdrawnTouchIsAskedAgain) {
    FloorDevice floor(header_.start);
    {
        JournalWriter writer = JournalWriter::create(file_, header_);
        JournalingDevice device(Journal{header_}, &writer, [&](const Point&) -> ProbeDevice& { return floor; });
        for (std::size_t k = 0; k < 5; ++k) (void)device.guarded_move(requests_[k].first, requests_[k].second);
    }
    JournalWriter writer(file_);
    JournalingDevice device(writer.read(), &writer, {});
    for (std::size_t k = 0; k < 5; ++k) (void)device.guarded_move(requests_[k].first, requests_[k].second);
    device.withdraw(2);
    const Journal journal = read_journal(file_);
    EXPECT_EQ(journal.moves.size(), 3U);
    EXPECT_EQ(journal.lines, 7U) << "nothing is taken out of the file";
}

// --- trail -----------------------------------------------------------------------------------------------------------

double length_of(const Point& from, const std::vector<Point>& way) { return path_length(from, way); }

const Region kAllAround(Ball{{5, 5, 5}, 100});

TEST(VisitedWays, WaysAreAsShortAsAnyOverTheMovesThatWereMade) {
    constexpr std::uint64_t kSeed = 21;
    SCOPED_TRACE(seed_text(kSeed));
    Random random(kSeed);
    for (int trial = 0; trial < 30; ++trial) {
        // A walk between few places, so that it comes back to them.
        std::vector<Point> places;
        for (int k = 0; k < 8; ++k) places.push_back(random.in_box(Point::Zero(), Point::Constant(10)));
        Journal journal{{"c", places[0], "m"}};
        std::vector<std::vector<double>> shortest(8, std::vector<double>(8, 1e9));
        std::size_t at = 0;
        for (std::size_t k = 0; k < 8; ++k) shortest[k][k] = 0;
        for (int k = 0; k < 14; ++k) {
            const std::size_t to = random.below(8);
            journal.moves.push_back({places[to], Pace::travel, {MoveResult::Outcome::reached, places[to]}, places[to]});
            const double length = (places[to] - places[at]).norm();
            shortest[at][to] = std::min(shortest[at][to], length);
            shortest[to][at] = std::min(shortest[to][at], length);
            at = to;
        }
        journal.moves.back().result.outcome = MoveResult::Outcome::contact;  // which confirms all of it
        for (std::size_t k = 0; k < 8; ++k) {
            for (std::size_t i = 0; i < 8; ++i) {
                for (std::size_t j = 0; j < 8; ++j) shortest[i][j] = std::min(shortest[i][j], shortest[i][k] + shortest[k][j]);
            }
        }
        const VisitedWays visited_ways(journal, kAllAround);
        for (std::size_t i = 0; i < 8; ++i) {
            if (shortest[0][i] > 1e8) {
                EXPECT_THROW((void)visited_ways.way(places[0], places[i]), std::invalid_argument);
                continue;
            }
            const auto way = visited_ways.way(places[0], places[i]);
            EXPECT_NEAR(length_of(places[0], way), shortest[0][i], 1e-9);
            EXPECT_EQ(way.empty(), i == 0);
        }
    }
}

TEST(VisitedWays, OutsideTheWorkspaceItGoesAroundIt) {
    const Region workspace(Ball{Point::Zero(), 5});
    Journal journal{{"c", {0, 0, 10}, "m"}};
    // In from above to a touch, and over a long way through the workspace to the side.
    const std::vector<Point> stops = {{0, 0, 5}, {0, 0, 2}, {-4, 0, 0}, {0, -4, 0}, {4, 0, 0}, {6, 0, 0}, {5, 0, 0}, {2, 0, 0}};
    for (const Point& p : stops) journal.moves.push_back({p, Pace::probe, {MoveResult::Outcome::contact, p}, p});
    const VisitedWays visited_ways(journal, workspace);
    const std::vector<Point> way = visited_ways.way({2, 0, 0}, {0, 0, 2});
    EXPECT_LT(path_length({2, 0, 0}, way), 3 + 5 * 1.7 + 3);
    for (std::size_t k = 1; k < way.size(); ++k) {
        const Point middle = (way[k - 1] + way[k]) / 2;
        EXPECT_TRUE(middle.norm() > 5 - 1e-9 || distance_to({{0, 0, 5}, {0, 0, 2}}, middle) < 1e-9) << middle.transpose();
    }
    EXPECT_NEAR(visited_ways.lengths({2, 0, 0}, {{0, 0, 2}})[0], path_length({2, 0, 0}, way), 1e-9);
    EXPECT_GT(visited_ways.lengths({2, 0, 0}, {{9, 9, 9}})[0], 1e9) << "never rested there";
}

// After the last touch the probe may have been dead, and what it found free be the part.
TEST(VisitedWays, WhatNothingConfirmsIsGoneBackOnlyWhereNoOtherWayLeads) {
    Journal journal{{"c", {0, 0, 0}, "m"}};
    const auto add = [&](const Point& p, MoveResult::Outcome outcome) { journal.moves.push_back({p, Pace::probe, {outcome, p}, p}); };
    add({0, 9, 0}, MoveResult::Outcome::reached);
    add({9, 9, 0}, MoveResult::Outcome::reached);
    add({9, 0, 0}, MoveResult::Outcome::contact);
    add({0, 0, 0}, MoveResult::Outcome::reached);  // a short cut
    add({5, 5, 5}, MoveResult::Outcome::reached);
    const VisitedWays visited_ways(journal, kAllAround);
    EXPECT_EQ(visited_ways.way({0, 0, 0}, {9, 0, 0}).size(), 3U);
    EXPECT_EQ(visited_ways.way({5, 5, 5}, {9, 0, 0}).size(), 4U);
}

TEST(VisitedWays, AMoveThatPassedNearAPlaceIsFound) {
    Journal journal{{"c", {0, 0, 0}, "m"}};
    for (const Point& p : {Point(10, 0, 0), Point(10, 10, 0)}) {
        journal.moves.push_back({p, Pace::travel, {MoveResult::Outcome::reached, p}, p});
    }
    const VisitedWays visited_ways(journal, kAllAround);
    const auto near = visited_ways.move_near({5, 0.01, 0}, 0.02);
    ASSERT_TRUE(near);
    EXPECT_LE(distance_to(*near, {5, 0.01, 0}), 0.0101);
    EXPECT_FALSE(visited_ways.move_near({5, 0.03, 0}, 0.02));
}

}  // namespace
}  // namespace palpate::journaling_device_test
