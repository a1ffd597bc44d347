// The driver on a bad wire: what is stale, late, damaged or lost is never taken for an answer.
#include <optional>

#include "tests/devices/grbl/grbl_support.h"

namespace palpate::grbl_device_wire_test {
namespace {

using testing::HasSubstr;
using Kind = VirtualFault::Kind;
using When = VirtualFault::When;
using Outcome = MoveResult::Outcome;

class GrblDeviceWire : public GrblDeviceTest {
protected:
    inline static const Point kTouch{kRadius, 0, 0};  // of the move from the start to the origin

    // While it reads a command a real controller says that it is idle.
    GrblDeviceWire() { options.parse_time = Seconds(0.004); }

    MoveResult probe() { return device->guarded_move({0, 0, 0}, Pace::probe); }
    // Whether there was an answer, which then is true.
    bool has_true_answer(const std::function<MoveResult()>& move, const Point& touch) {
        try {
            expect_touch(move(), touch);
            return true;
        } catch (const DeviceError&) {
            return false;
        }
    }
};

INSTANTIATE_TEST_SUITE_P(Dialects, GrblDeviceWire, testing::Values(GrblDialect::grbl, GrblDialect::grblhal), dialect_name);

// --- stale -----------------------------------------------------------------------------------------------------------

TEST_P(GrblDeviceWire, AStaleOkIsNotCredited) {
    for (double line = 1; line <= 12; ++line) {
        SCOPED_TRACE(line);
        options.faults = {{Kind::stale_line, When::line, line, 0, "ok"}, {Kind::stale_line, When::line, line, 0, "ok"}};
        power_on();
        ready();
        expect_touch(probe(), kTouch);
        EXPECT_EQ(device->guarded_move({20, 0, 0}, Pace::travel).outcome, Outcome::reached);
        EXPECT_NEAR((tool_at() - Point(20, 0, 0)).norm(), 0, kMicrometre);
    }
}

TEST_P(GrblDeviceWire, StaleOksWhileTheToolMovesAreNotCredited) {
    ready();
    for (double moment = 0; moment < 3; moment += 0.1) {
        options.faults.push_back({Kind::stale_line, When::time, seconds() + moment, 0, "ok"});
    }
    power_on();
    ready();
    expect_touch(probe(), kTouch);
}

// An answer of an older command, with its ok, on the way of this one.
TEST_P(GrblDeviceWire, AStaleAnswerIsNotCreditedWhileTheToolMoves) {
    options.faults = {{Kind::stale_line, When::probe, 1, 0, "[PRB:19.500,-2.000,3.000:1]"}, {Kind::stale_line, When::probe, 1, 0, "ok"}};
    ready();
    expect_touch(probe(), kTouch);
    EXPECT_NEAR((tool_at() - Point(10.5, 0, 0)).norm(), 0, kMicrometre);
}

// ... where it would be credible, before the tool has begun to move.
TEST_P(GrblDeviceWire, AStaleAnswerThatComesAtOnceIsNotCredited) {
    tool_options.start = Point(11, 0, 0) + kOrigin;
    options.faults = {{Kind::stale_line, When::probe, 1, 0, "[PRB:11.600,-2.000,3.000:1]"}, {Kind::stale_line, When::probe, 1, 0, "ok"}};
    ready();
    expect_touch(probe(), kTouch);
}

TEST_P(GrblDeviceWire, WhatCameBeforeAMoveIsNotItsAnswer) {
    options.faults = {{Kind::stale_line, When::time, 30.0, 0, "[PRB:10.000,-2.000,3.000:1]"},
                      {Kind::stale_line, When::time, 30.0, 0, "ok"},
                      {Kind::stale_line, When::time, 30.0, 0, "error:9"}};
    ready();
    ASSERT_LT(seconds(), 30);
    grbl->advance(Seconds(31.0));
    const auto begin = seconds();
    EXPECT_EQ(device->guarded_move({20, 0, 10}, Pace::travel), (MoveResult{Outcome::reached, {20, 0, 10}, {}}));
    EXPECT_LT(seconds() - begin, 1.5);
}

// --- lost ------------------------------------------------------------------------------------------------------------

// From the moment of the touch on: the answer, its ok, reports of status, the answers of the way back.
TEST_P(GrblDeviceWire, BytesLostAtAnyPositionOfAnAnswerNeverMakeAFalseOne) {
    int answers = 0;
    int faults = 0;
    for (const std::size_t count : {1U, 2U, 7U, 30U}) {
        for (std::size_t first = 0; first < 250; ++first) {
            SCOPED_TRACE(testing::Message() << count << " bytes from byte " << first);
            power_on();
            ready();
            stream->before_read = [&] {
                if (tool->is_probe_closed()) {
                    stream->to_host.lose(first, count);
                    stream->before_read = nullptr;
                }
            };
            has_true_answer([&] { return probe(); }, kTouch) ? ++answers : ++faults;
            EXPECT_FALSE(tool->is_moving());
        }
    }
    EXPECT_GT(answers, 4 * faults) << "most losses are made good";
    EXPECT_GT(faults, 0) << "no loss hit anything that matters";
}

// A minus that is lost leaves another number, which here lies on the way, too, and close by.
TEST_P(GrblDeviceWire, ALostSignIsNotAnotherTouch) {
    const Point origin(-kRadius - 0.3, -2, 3);
    tool_options.origin = device_options.origin = origin;
    tool_options.start = Point(20, 0, 0) + origin;
    for (std::size_t first = 0; first < 100; ++first) {
        SCOPED_TRACE(first);
        power_on();
        ready();
        stream->before_read = [&] {
            if (tool->is_probe_closed()) {
                stream->to_host.lose(first, 1);
                stream->before_read = nullptr;
            }
        };
        has_true_answer([&] { return probe(); }, kTouch);
    }
}

TEST_P(GrblDeviceWire, ALostDigitOfInchesIsNotAnotherTouch) {
    constexpr double kInchDigit = 0.00254;  // mm
    options.report_inches = true;
    for (std::size_t first = 0; first < 100; ++first) {
        SCOPED_TRACE(first);
        power_on();
        ready();
        stream->before_read = [&] {
            if (tool->is_probe_closed()) {
                stream->to_host.lose(first, 1);
                stream->before_read = nullptr;
            }
        };
        try {
            EXPECT_NEAR((probe().position - kTouch).norm(), 0, kInchDigit);
        } catch (const DeviceError&) {
        }
    }
}

TEST_P(GrblDeviceWire, AnAnswerThatGotLostIsAskedForAgain) {
    ready();
    (void)probe();
    const auto probes = grbl->counts().probes;
    power_on();
    ready();
    stream->before_read = [&] {
        if (tool->is_probe_closed()) {
            stream->to_host.lose(0, 40);
            stream->before_read = nullptr;
        }
    };
    const MoveResult result = probe();
    expect_touch(result, kTouch);
    ASSERT_EQ(result.events.size(), 1U);
    EXPECT_EQ(result.events[0].kind, DeviceEvent::Kind::repeated_command);
    EXPECT_EQ(grbl->counts().probes, probes) << "it was not made again";
}

// The touch, the way out, and the touch again can all be latched at one place.
TEST_P(GrblDeviceWire, ALostAnswerIsFoundEvenIfItIsTheSameAsTheLast) {
    ready();
    expect_touch(probe(), kTouch);
    ASSERT_EQ(device->guarded_move({10.5, 1, 0}, Pace::travel).outcome, Outcome::reached);
    ASSERT_EQ(device->guarded_move({10.5, 0, 0}, Pace::travel).outcome, Outcome::reached);
    expect_touch(probe(), kTouch);
    stream->before_read = [&] {
        if (grbl->counts().probes == 7 && !tool->is_probe_closed() && tool->is_moving()) {
            stream->to_host.lose(0, 10);
            stream->before_read = nullptr;
        }
    };
    expect_touch(probe(), kTouch);
}

TEST_P(GrblDeviceWire, ACommandThatGotLostIsSentAgainOnce) {
    ready();
    ASSERT_EQ(device->guarded_move({20, 0, 1}, Pace::travel).outcome, Outcome::reached);
    ASSERT_EQ(device->guarded_move({20, 0, 0}, Pace::travel).outcome, Outcome::reached);
    stream->to_machine.lose(0, std::string("G21G90G94G38.3N9999999X1.000Y-2.000Z3.000F300\n").size());
    const MoveResult result = probe();
    expect_touch(result, kTouch);
    ASSERT_EQ(result.events.size(), 1U);
    EXPECT_EQ(result.events[0].kind, DeviceEvent::Kind::repeated_command);
}

// Of the first command after a reset, and of a later one. Even if all of its G38.3 is lost, nothing moves unguarded.
TEST_P(GrblDeviceWire, BytesLostAtAnyPositionOfACommandNeverMakeAFalseAnswerOrAnUnguardedMove) {
    int faults = 0;
    for (const bool is_first : {true, false}) {
        for (const std::size_t count : {1U, 2U, 3U, 5U, 11U}) {
            for (std::size_t first = 0; first < 60; ++first) {
                SCOPED_TRACE(testing::Message() << count << " bytes from byte " << first << (is_first ? " of the first" : ""));
                power_on();
                ready();
                if (!is_first) {
                    ASSERT_EQ(device->guarded_move({20, 0, 1}, Pace::travel).outcome, Outcome::reached);
                    ASSERT_EQ(device->guarded_move({20, 0, 0}, Pace::travel).outcome, Outcome::reached);
                }
                stream->to_machine.lose(first, count);
                faults += has_true_answer([&] { return probe(); }, kTouch) ? 0 : 1;
                EXPECT_EQ(tool->audit().unguarded_moves, 0U);
                EXPECT_LT((tool_at() - Point(15, 0, 0)).norm(), 10) << "it ran away to " << tool_at().transpose();
                EXPECT_LT(tool->audit().deepest_mm, 1.2) << "it was faster than any feed";
            }
        }
    }
    EXPECT_GT(faults, 100) << "no loss hit anything that matters";
}

// Where an X that ends in 0.000 or 1.000 would join the G of what is left to a rapid (G0, G30) or a feed move (G1).
TEST_P(GrblDeviceWire, BytesLostBeforeACoordinateNeverJoinItToAnUnguardedMove) {
    const std::string guard = "G21G90G94G38.3N9999999X";
    for (const double x : {0.0, 1.0, 10.0, 21.0, -11.0, 0.2}) {
        device_options.origin = tool_options.origin = Point(x, -2, 3);
        tool_options.start = Point(0, 20, 0) + tool_options.origin;
        for (std::size_t count = 1; count <= 11; ++count) {
            for (std::size_t first = 0; first < guard.size(); ++first) {
                SCOPED_TRACE(testing::Message() << count << " bytes from byte " << first << ", X" << x);
                power_on();
                ready();
                ASSERT_EQ(device->guarded_move({0, 20, 1}, Pace::travel).outcome, Outcome::reached);
                stream->to_machine.lose(first, count);
                has_true_answer([&] { return device->guarded_move({0, 0, 0}, Pace::probe); }, *ball.first_hit({{0, 20, 1}, {0, 0, 0}}));
                EXPECT_EQ(tool->audit().unguarded_moves, 0U);
            }
        }
    }
}

// A shift of the work offset that nobody told the driver of, with the report that first tells it damaged.
TEST_P(GrblDeviceWire, ADamagedWorkOffsetMovesNothingElsewhere) {
    for (std::size_t first = 0; first < 3000; ++first) {
        SCOPED_TRACE(first);
        options.work_offset = Point(12, 0, 0);
        power_on();
        ready();
        stream->to_host.lose(first, 1);
        for (int k = 0; k < 12; ++k) {
            const double x = k % 2 == 0 ? 25 : 20;
            try {
                (void)device->guarded_move({x, 0, 0}, Pace::travel);
            } catch (const DeviceError&) {
                break;
            }
            EXPECT_NEAR(tool_at().x(), x, kMicrometre);
        }
        EXPECT_GT(tool_at().x(), 20 - kMicrometre);
        EXPECT_LT(tool_at().x(), 25 + kMicrometre);
    }
}

// A reset ends a shift (G92): the way back is not reckoned with it.
TEST_P(GrblDeviceWire, TheWayBackAfterAStopKnowsNoShiftThatTheResetEnded) {
    for (const int mask : {0, 1}) {
        for (std::size_t first = 0; first < 400; ++first) {
            SCOPED_TRACE(testing::Message() << "byte " << first << ", $10=" << mask);
            stop = {};
            options.status_mask = mask;
            power_on();
            (void)behind_its_back("$X\nG92Y1.5\n");
            ready();
            once_within(15, [&] {
                stop.request_stop();
                stream->to_host.lose(first, 1);
            });
            try {
                (void)device->guarded_move({10, 0, 0}, Pace::travel);
                ADD_FAILURE() << "it was not stopped";
            } catch (const Stopped&) {
                EXPECT_NEAR((tool_at() - Point(20, 0, 0)).norm(), 0, kMicrometre);
            } catch (const DeviceError&) {
                EXPECT_NEAR(tool_at().y(), 0, kMicrometre);
                EXPECT_LT(tool_at().x(), 20 + kMicrometre);
            }
        }
    }
}

// --- late ------------------------------------------------------------------------------------------------------------

TEST_P(GrblDeviceWire, LateAnswersAreWaitedForAndDoNotFallBehind) {
    options.faults = {{Kind::late_answer, When::probe, 1, 2.5}, {Kind::late_answer, When::probe, 4, 2.5}};
    ready();
    expect_touch(probe(), kTouch);
    EXPECT_EQ(device->guarded_move({20, 0, 0}, Pace::travel).outcome, Outcome::reached);
    EXPECT_EQ(device->guarded_move({20, 5, 0}, Pace::travel).outcome, Outcome::reached);
    once_within(15, [&] { stop.request_stop(); });
    EXPECT_THROW((void)device->guarded_move({10, 5, 0}, Pace::travel), Stopped);
    EXPECT_NEAR((tool->true_position() - tool->position()).norm(), 0, kMicrometre);
    EXPECT_NEAR((tool_at() - Point(20, 5, 0)).norm(), 0, kMicrometre);
}

// Reports that were asked for long ago must not tell a tool that moves as one that rests: it would be reset in mid-move.
TEST_P(GrblDeviceWire, AStopAsTheMoveBeginsIsNotDeceivedByOldReports) {
    ready();
    for (double delay = 0.001; delay < 0.3; delay += 0.013) {
        SCOPED_TRACE(delay);
        stop = {};
        device_options.homing = Homing::require;
        ready();
        grbl->receive("??????????");
        const double begin = seconds();
        stream->before_read = [&] {
            if (seconds() >= begin + delay) stop.request_stop();
        };
        EXPECT_THROW((void)device->guarded_move({20, 20, 0}, Pace::travel), Stopped);
        stream->before_read = nullptr;
        EXPECT_NEAR((tool->true_position() - tool->position()).norm(), 0, kMicrometre);
        EXPECT_NEAR((tool_at() - Point(20, 0, 0)).norm(), 0, kMicrometre);
    }
}

TEST_P(GrblDeviceWire, AToolThatMovesIsStoppedWhenAnErrorOfSomethingElseComes) {
    ready();
    double moment = 0;
    once_within(15, [&] { moment = seconds(); });
    expect_touch(probe(), kTouch);
    options.faults = {{Kind::stale_line, When::time, moment, 0, "error:20"}};
    power_on();
    ready();
    EXPECT_THROW((void)probe(), DeviceRefused);
    EXPECT_FALSE(tool->is_moving());
    EXPECT_GT(tool_at().x(), 13);
    EXPECT_NEAR((tool->true_position() - tool->position()).norm(), 0, kMicrometre);
    EXPECT_THROW((void)device->guarded_move({20, 0, 0}, Pace::travel), PositionLost) << "nobody knows where it stands";
}

// The same just before the tool begins to move.
TEST_P(GrblDeviceWire, AToolThatIsAboutToMoveIsStoppedWhenAnErrorOfSomethingElseComes) {
    options.faults = {{Kind::stale_line, When::probe, 1, 0, "error:20"}};
    ready();
    EXPECT_THROW((void)device->guarded_move({20, 40, 0}, Pace::probe), DeviceError);
    grbl->advance(Seconds(20));
    EXPECT_LT(tool_at().y(), 1);
}

// The wire to the host is cut, the other one is not.
TEST_P(GrblDeviceWire, AToolThatIsNotHeardAnyMoreIsToldToHold) {
    ready();
    stream->before_read = [&] {
        if (tool_at().z() < 2) return;
        stream->to_host.lose(0, 100'000);
        stream->before_read = nullptr;
    };
    EXPECT_THROW((void)device->guarded_move({20, 0, 40}, Pace::touch), DeviceTimeout);
    grbl->advance(Seconds(10));
    EXPECT_LT(tool_at().z(), 8);
    EXPECT_FALSE(tool->is_moving());
}

// One report shows that the tool goes elsewhere (a minus got lost), then nothing comes any more.
TEST_P(GrblDeviceWire, AToolThatGoesElsewhereAndIsNotHeardAnyMoreIsToldToHold) {
    tool_options.origin = device_options.origin = Point(1, 0, 3);
    tool_options.start = Point(20, 0, 0) + tool_options.origin;
    ready();
    const std::string line = "G21G90G94G38.3N9999999X21.000Y";
    ASSERT_EQ(device->guarded_move({20, 0, 1}, Pace::travel).outcome, Outcome::reached);
    stream->to_machine.lose(line.size(), 1);
    stream->before_read = [&] {
        if (std::abs(tool->true_position().y()) < 1.5) return;
        stream->to_host.lose(60, 100'000);
        stream->before_read = nullptr;
    };
    EXPECT_THROW((void)device->guarded_move({20, -40, 1}, Pace::probe), DeviceError);
    grbl->advance(Seconds(60));
    EXPECT_FALSE(tool->is_moving());
    EXPECT_LT(std::abs(tool->true_position().y()), 40);
}

// --- gone ------------------------------------------------------------------------------------------------------------

TEST_P(GrblDeviceWire, AnAnswerThatIsFarTooLateIsATimeoutAndNeverCredited) {
    options.faults = {{Kind::late_answer, When::probe, 2, 20.0}};
    ready();
    ASSERT_EQ(device->guarded_move({20, 1, 0}, Pace::travel).outcome, Outcome::reached);
    EXPECT_THROW((void)probe(), DeviceTimeout);
    grbl->advance(Seconds(30.0));
    EXPECT_THROW((void)device->guarded_move({20, 0, 0}, Pace::travel), PositionLost);
    connect();  // reads all that came meanwhile
    device->retreat({20, 1, 0});
    device->make_ready();
    expect_touch(device->guarded_move({0, 1, 0}, Pace::probe), *ball.first_hit({{20, 1, 0}, {0, 1, 0}}));
}

TEST_P(GrblDeviceWire, SilenceIsATimeoutThatNamesWhatWasAwaitedWithTheLastLines) {
    options.faults = {{Kind::silence, When::probe, 1}};
    ready();
    const double begin = seconds();
    const std::string message = message_of<DeviceTimeout>([&] { (void)probe(); });
    EXPECT_LT(seconds() - begin, 5.0);
    EXPECT_THAT(message, HasSubstr("waiting for the end of a probing move"));
    EXPECT_THAT(message, HasSubstr("> G21G90G94G38.3N9999999X1.000Y-2.000Z3.000F300\n"));
    EXPECT_THAT(message, HasSubstr("< ok"));
    EXPECT_THROW((void)probe(), PositionLost);
}

TEST_P(GrblDeviceWire, APulledCableIsAConnectionLostWhateverIsUnderWay) {
    int faults = 0;
    for (const Kind kind : {Kind::hang_up, Kind::io_error}) {
        for (double moment = 0; moment < 3; moment += 0.05) {
            SCOPED_TRACE(moment);
            options.faults = {{kind, When::time, moment}};
            power_on();
            try {
                ready();
                expect_touch(probe(), kTouch);
                EXPECT_LT(seconds(), moment);
                continue;
            } catch (const ConnectionLost& fault) {
                EXPECT_THAT(fault.what(), HasSubstr("virtual GRBL"));
            }
            ++faults;
            // The machine ends by itself what was under way; a new host finds it.
            grbl->plug_in();
            connect();
            device->retreat({20, 0, 0});
            device->make_ready();
            expect_touch(probe(), kTouch);
        }
    }
    EXPECT_GT(faults, 80);
}

}  // namespace
}  // namespace palpate::grbl_device_wire_test
