#include "support/undisturbed.h"

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace twin::test::undisturbed_test {
namespace {

int attempts = 0;

/// A host that spoils so many cycles in a row of every attempt.
WatchHost Spoiling(std::int64_t cycles) {
  return [cycles] { return [cycles] { return Lateness{cycles, cycles, cycles * kCycle}; }; };
}

std::int64_t TwentyCycles() {
  return kEndsAMotion;
}

TEST(UndisturbedTest, AnAttemptWithoutFailureIsTheLastOnWhateverHost) {
  attempts = 0;
  Undisturbed([] { ++attempts; }, &TwentyCycles, Spoiling(1000));
  EXPECT_EQ(attempts, 1);
}

void AbortBesideAHostThatSpoils(std::int64_t cycles) {
  Undisturbed(
      [] {
        ++attempts;
        ADD_FAILURE() << "communication_constraints_violation; this machine gives it no time";
      },
      &TwentyCycles, Spoiling(cycles), 4);
}

TEST(UndisturbedTest, AnAbortBesideAQuietWitnessFailsWhateverItSays) {
  attempts = 0;
  EXPECT_NONFATAL_FAILURE(AbortBesideAHostThatSpoils(0), "communication_constraints_violation");
  EXPECT_NONFATAL_FAILURE(AbortBesideAHostThatSpoils(19), "the host spoilt 19 cycles in a row");
  EXPECT_EQ(attempts, 2);
}

TEST(UndisturbedTest, AnAbortBesideALateWitnessIsRepeatedAndThenSkips) {
  attempts = 0;
  ::testing::TestPartResultArray found;
  {
    const ::testing::ScopedFakeTestPartResultReporter reporter(
        ::testing::ScopedFakeTestPartResultReporter::INTERCEPT_ONLY_CURRENT_THREAD, &found);
    AbortBesideAHostThatSpoils(20);
  }
  EXPECT_EQ(attempts, 4);
  ASSERT_EQ(found.size(), 1);
  EXPECT_TRUE(found.GetTestPartResult(0).skipped());
}

TEST(UndisturbedTest, ARepeatedAttemptMayHold) {
  attempts = 0;
  Undisturbed([] { EXPECT_EQ(++attempts, 3); }, &TwentyCycles, Spoiling(20));
  EXPECT_EQ(attempts, 3);
}

TEST(UndisturbedTest, AnErrorIsExcusedAsAFailureIs) {
  attempts = 0;
  const auto refuse = [] {
    if (++attempts < 3) throw RobotFault("no answer");
  };
  EXPECT_THROW(Undisturbed(refuse, &TwentyCycles, Spoiling(19)), RobotFault);
  attempts = 0;
  Undisturbed(refuse, &TwentyCycles, Spoiling(20));
  EXPECT_EQ(attempts, 3);
}

TEST(UndisturbedTest, WhatIsNoErrorOfTheWorldIsPassedOnAtOnce) {
  EXPECT_THROW(Undisturbed([] { throw std::runtime_error("a bug"); }, &TwentyCycles, Spoiling(20)),
               std::runtime_error);
}

TEST(UndisturbedTest, UnlessToldOnlyAThreadThatDidNotRunForASecondIsExcused) {
  const auto failing = [](std::int64_t cycles) {
    Undisturbed([] { EXPECT_EQ(++attempts, 2); }, [] { return kGivenUp; }, Spoiling(cycles));
  };
  attempts = 0;
  EXPECT_NONFATAL_FAILURE(failing(899), "the host spoilt 899");
  attempts = 0;
  failing(900);
  EXPECT_EQ(attempts, 2);
}

TEST(CountSpoiltTest, JoinsWhatOverlapsOrTouches) {
  const auto in_row = [](const std::vector<CycleRange>& spoilt) {
    return CountSpoilt(spoilt).spoilt_in_row;
  };
  EXPECT_EQ(in_row({}), 0);
  EXPECT_EQ(in_row({{5, 6}}), 2);
  EXPECT_EQ(in_row({{5, 6}, {8, 12}}), 5);
  EXPECT_EQ(in_row({{8, 12}, {5, 7}}), 8) << "touching, of two processors";
  EXPECT_EQ(in_row({{5, 20}, {7, 9}, {21, 22}}), 18);
}

TEST(CountSpoiltTest, CountsEachCycleOnceInAnyFiveHundred) {
  const auto of_500 = [](const std::vector<CycleRange>& spoilt) {
    return CountSpoilt(spoilt).spoilt_of_500;
  };
  EXPECT_EQ(of_500({{5, 6}, {6, 8}, {100, 100}}), 5);
  EXPECT_EQ(of_500({{1, 1}, {500, 500}}), 2);
  EXPECT_EQ(of_500({{1, 1}, {501, 501}}), 1);
  EXPECT_EQ(of_500({{1, 2000}}), 500);
}

TEST(WitnessTest, SeesNothingOfARunThatIsOverAtOnce) {
  Witness witness(0);
  EXPECT_LT(witness.End().spoilt_in_row, 1000);
}

}  // namespace
}  // namespace twin::test::undisturbed_test
