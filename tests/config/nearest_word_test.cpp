#include "config/nearest_word.h"

#include <gtest/gtest.h>

#include <array>
#include <string>

namespace palpate::nearest_word_test {
namespace {

constexpr std::array<std::string_view, 5> kWords{"simulate", "check", "probe", "vm", "probed"};

TEST(NearestWord, TwoSlipsOfTheFingerAreForgiven) {
    EXPECT_EQ(nearest_word("simulat", kWords), "simulate");
    EXPECT_EQ(nearest_word("chekc", kWords), "check");
    EXPECT_EQ(nearest_word("probr", kWords), "probe") << "the first of equals";
    EXPECT_EQ(nearest_word("sim", kWords), "");
    EXPECT_EQ(nearest_word("", kWords), "");
    EXPECT_EQ(nearest_word("help", kWords), "");
}

TEST(NearestWord, AWordWithoutALetterInCommonIsAnother) {
    EXPECT_EQ(nearest_word("vn", kWords), "vm");
    EXPECT_EQ(nearest_word("xy", kWords), "");
}

TEST(NearestWord, IsProposedInAMessage) {
    EXPECT_EQ(did_you_mean("simulat", kWords), "; did you mean \"simulate\"?");
    EXPECT_EQ(did_you_mean("nonsense", kWords), "");
    EXPECT_EQ(did_you_mean(std::string(1'000'000, 'x'), kWords), "");
    EXPECT_EQ(did_you_mean("simulat", {}), "");
}

}  // namespace
}  // namespace palpate::nearest_word_test
