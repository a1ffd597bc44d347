// Lines of a program that drives a machine, good and bad.
#include "devices/external/internal/external_message.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace palpate::external::external_message_test {
namespace {

using ::testing::HasSubstr;

std::string why(const std::string& text) {
    const auto parsed = parse(text);
    const auto* malformed = std::get_if<Malformed>(&parsed);
    return malformed != nullptr ? malformed->why : "good";
}

TEST(ExternalMessage, AnswersAreRead) {
    const auto line = std::get<Line>(parse(R"({"id": 3, "ended": "probe", "touched": [1, 2.5, -3], "position": [1, 2.5, -3.1],
                                              "probe": "closed", "unheard of": {}})"));
    EXPECT_EQ(line.id, 3U);
    EXPECT_EQ(line.ended, "probe");
    EXPECT_EQ(line.touched, Point(1, 2.5, -3));
    EXPECT_EQ(line.position, Point(1, 2.5, -3.1));
    EXPECT_EQ(line.probe_closed, true);
    EXPECT_FALSE(line.error || line.homed);
    const auto hello = std::get<Line>(parse(R"({"id": 1, "name": "a", "limits": {"min": [0, 0, 0], "max": [1, 2, 3]}, "feed": 5,
                                               "acceleration": 6, "resolution": 0.1, "stops_at_touch": true, "latches": false})"));
    EXPECT_EQ(hello.limits->max, Point(1, 2, 3));
    EXPECT_EQ(hello.latches, false);
    EXPECT_FALSE(std::get<Line>(parse(R"({"alive": true, "position": [0, 0, 0]})")).id);
}

TEST(ExternalMessage, WhatIsWrongIsNamed) {
    EXPECT_EQ(why("moved"), "is no JSON");
    EXPECT_EQ(why("[1, 2]"), "is no JSON object");
    EXPECT_EQ(why("{}"), "has neither an \"id\" nor \"alive\": true");
    EXPECT_EQ(why(R"({"alive": false})"), "has neither an \"id\" nor \"alive\": true");
    EXPECT_EQ(why(R"({"id": -1})"), "\"id\" is no whole number");
    EXPECT_EQ(why(R"({"id": "1"})"), "\"id\" is no whole number");
    EXPECT_EQ(why(R"({"id": 1, "position": [1, 2]})"), "\"position\" is no list of three finite numbers");
    EXPECT_EQ(why(R"({"id": 1, "touched": [1, 2, null]})"), "\"touched\" is no list of three finite numbers");
    EXPECT_EQ(why(R"({"id": 1, "touched": [1, 2, 1e999]})"), "is no JSON") << "no double";
    EXPECT_EQ(why(R"({"id": 1, "probe": "shut"})"), "\"probe\" is neither \"open\" nor \"closed\"");
    EXPECT_EQ(why(R"({"id": 1, "moving": 0})"), "\"moving\" is neither true nor false");
    EXPECT_EQ(why(R"({"id": 1, "error": 5})"), "\"error\" is no text");
    EXPECT_EQ(why(R"({"id": 1, "limits": [0, 1]})"), "\"limits\" has no min and max");
    EXPECT_EQ(why(R"({"id": 1, "feed": "5"})"), "\"feed\" is no finite number");
    EXPECT_EQ(why("{\"id\": 1, \"name\": \"\xff\"}"), "is no JSON") << "no UTF-8";
}

TEST(ExternalMessage, QuestionsAreOneLineEach) {
    const std::string move = ask_move(7, {true, Point(1, -0.0025, 3), 20, 200, false});
    EXPECT_EQ(move, R"({"id":7,"ask":"travel","to":[1.0,-0.0025,3.0],"feed":20.0,"acceleration":200.0,"until":"closed"})"
                    "\n");
    EXPECT_THAT(ask_move(8, {false, Point::Zero(), 5, 200, true}), HasSubstr(R"("ask":"move_guarded")"));
    EXPECT_EQ(ask(2, "state"), "{\"id\":2,\"ask\":\"state\"}\n");
    EXPECT_TRUE(nlohmann::json::accept(ask_hello(1, 0.5)));
    EXPECT_TRUE(nlohmann::json::accept(kAlive));
}

}  // namespace
}  // namespace palpate::external::external_message_test
