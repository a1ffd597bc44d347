#include "planner/loop/effort.h"

#include <gtest/gtest.h>

namespace palpate::effort_test {
namespace {

TEST(Effort, APlaceIsSpentAfterItsTriesAndMoreForEverySample) {
    Effort effort(1.0);
    const Point here(0.5, 0.5, 0.5);
    const Point elsewhere(100, 0, 0);
    effort.note_probes(here, Effort::kTries);
    EXPECT_FALSE(effort.is_spent(here));
    effort.note_probes(here, 1);
    EXPECT_TRUE(effort.is_spent(here));
    EXPECT_TRUE(effort.is_spent({0.6, 0.5, 0.5})) << "the same place";
    EXPECT_FALSE(effort.is_spent(elsewhere));
    effort.note_sample(here);
    EXPECT_FALSE(effort.is_spent(here));
    effort.note_probes(here, Effort::kPerSample);
    EXPECT_TRUE(effort.is_spent(here));
}

TEST(Effort, NamesEveryPlaceOnce) {
    Effort effort(1.0);
    effort.give_up({0.5, 0.5, 0.5});
    effort.give_up({0.7, 0.5, 0.5});
    effort.give_up({-100, 0, 0});
    ASSERT_EQ(effort.given_up().size(), 2U);
    EXPECT_EQ(effort.given_up()[1].x(), -100);
}

TEST(Effort, GuessesThatMostlyFailAreLeftAlone) {
    Effort effort(1.0);
    const Point here(0.5, 0.5, 0.5);
    effort.note_guess(here, Effort::kGuesses, false);
    EXPECT_FALSE(effort.is_guesswork(here));
    effort.note_guess(here, 10, true);
    effort.note_guess(here, 10, false);
    EXPECT_FALSE(effort.is_guesswork(here));
    effort.note_guess(here, 1, false);
    EXPECT_TRUE(effort.is_guesswork(here));
    EXPECT_FALSE(effort.is_spent(here)) << "that only ends guessing";
}

}  // namespace
}  // namespace palpate::effort_test
