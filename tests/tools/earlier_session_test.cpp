#include "tools/earlier_session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "devices/errors.h"
#include "tools/session_files.h"

namespace palpate::earlier_session_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string complaint_about(const std::string& csv) {
    try {
        (void)parse_touches(csv, "old.csv");
    } catch (const SetupError& error) {
        return error.what();
    }
    return "nothing";
}

TEST(EarlierSession, WhatWasWrittenReadsBackBitForBit) {
    const std::vector<Touch> touches = {{{1.0 / 3, -2e-300, 3}, {1, 2, 4.1}, Touch::Role::seed_facet, 7},
                                        {{0.1 + 0.2, 0, 0}, {1, 0, 0}, Touch::Role::crossing, std::nullopt}};
    const std::vector<EarlierTouch> read = parse_touches(to_csv(touches), "old.csv");
    ASSERT_EQ(read.size(), 2U);
    for (std::size_t k = 0; k < 2; ++k) {
        EXPECT_EQ(read[k].position, touches[k].position);
        EXPECT_EQ(read[k].from, touches[k].from);
        EXPECT_EQ(read[k].is_sample, touches[k].sample.has_value());
    }
}

TEST(EarlierSession, ColumnsAreFoundByName) {
    const auto read = parse_touches("mine,from_z,from_y,from_x,z,y,x\r\na b,6,5,4,3,2,1\r\n", "old.csv");
    ASSERT_EQ(read.size(), 1U);
    EXPECT_EQ(read[0].position, Point(1, 2, 3));
    EXPECT_EQ(read[0].from, Point(4, 5, 6));
    EXPECT_FALSE(read[0].is_sample);
}

TEST(EarlierSession, FixturesAreNotTouched) {
    const auto read = parse_touches(
        "x,y,z,from_x,from_y,from_z,sample,tag\n1,2,3,1,2,9,0,fixture\n1,2,3,1,2,9,2,untouched\n1,2,3,1,2,9,1,tip\n", "old.csv");
    ASSERT_EQ(read.size(), 1U);
    EXPECT_TRUE(read[0].is_sample);
}

TEST(EarlierSession, BadFilesGetOneMessageWithTheirLine) {
    const std::string header = "x,y,z,from_x,from_y,from_z\n";
    EXPECT_THAT(complaint_about(""), StartsWith("old.csv:1: has no column x"));
    EXPECT_THAT(complaint_about("x,y,from_x,from_y,from_z\n"), StartsWith("old.csv:1: has no column z"));
    EXPECT_EQ(complaint_about(header), "old.csv: has no touches");
    EXPECT_THAT(complaint_about(header + "1,2,3,4,5,6\n1,2,3,4,5\n"), StartsWith("old.csv:3: has 5 fields, not the 6"));
    EXPECT_THAT(complaint_about(header + "\n"), StartsWith("old.csv:2: has 1 fields"));
    for (const char* bad : {"", "nan", "inf", "1e999", "0x10", "1 ", "1;2", "eins"}) {
        EXPECT_EQ(complaint_about(header + "1,2,3,4," + bad + ",6\n"),
                  std::string("old.csv:2: from_y is \"") + bad + "\"; allowed: a finite number (mm)");
    }
    EXPECT_THAT(complaint_about(std::string("\0\xff\0,,,\n", 8)), StartsWith("old.csv:1: has no column x"));
}

TEST(EarlierSession, AFolderWithoutTouchesIsNoSession) {
    std::string name = (fs::temp_directory_path() / "palpate_earlier_XXXXXX").string();
    const fs::path folder = mkdtemp(name.data());
    try {
        (void)earlier_touches_in(folder);
        ADD_FAILURE();
    } catch (const SetupError& error) {
        EXPECT_THAT(error.what(), HasSubstr("holds neither touches.csv nor journal.jsonl"));
    }
    write_file(folder / "touches.csv", "x\n");
    EXPECT_EQ(earlier_touches_in(folder), "x\n");
    fs::remove_all(folder);
}

}  // namespace
}  // namespace palpate::earlier_session_test
