#include "support/undisturbed.h"

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace twin::test {
namespace {

int attempts = 0;

TEST(UndisturbedTest, AnAttemptWithoutFailureIsTheLast) {
  attempts = 0;
  Undisturbed([] { ++attempts; });
  EXPECT_EQ(attempts, 1);
}

TEST(UndisturbedTest, WhatFailedUndisturbedIsAFailure) {
  attempts = 0;
  const auto failing = [] {
    Undisturbed([] {
      ++attempts;
      EXPECT_EQ(1, 2) << "the claim";
    });
  };
  EXPECT_NONFATAL_FAILURE(failing(), "the claim");
  EXPECT_EQ(attempts, 1);
}

TEST(UndisturbedTest, WhatTheMachineSpoiltIsTriedAgain) {
  attempts = 0;
  Undisturbed([] { EXPECT_EQ(++attempts, 3); }, [] { return attempts < 3; });
  EXPECT_EQ(attempts, 3);
}

TEST(UndisturbedTest, NoErrorIsExcusedByItsText) {
  EXPECT_THROW(Undisturbed([] { throw RobotFault("no answer; this machine gives it no time"); }),
               RobotFault);
}

TEST(UndisturbedTest, TheMachineIsToBlameWhereAnErrorSaysSo) {
  attempts = 0;
  Undisturbed([] {
    if (++attempts < 3) throw RobotFault("no answer; this machine gives it no time");
  });
  EXPECT_EQ(attempts, 3);
}

TEST(UndisturbedTest, AFailureThatQuotesSuchAnErrorIsTriedAgain) {
  attempts = 0;
  const auto starve = [] {
    if (++attempts < 3) throw RobotFault("no answer; this machine gives it no time");
    throw InputError("refused");
  };
  Undisturbed([&] { EXPECT_THROW(starve(), InputError); });
  EXPECT_EQ(attempts, 3);
}

TEST(UndisturbedTest, AnyOtherErrorIsPassedOn) {
  EXPECT_THROW(Undisturbed([] { throw RobotFault("refused"); }), RobotFault);
  EXPECT_THROW(Undisturbed([] { throw std::runtime_error("a bug"); }), std::runtime_error);
}

TEST(UndisturbedTest, ATestWhoseEveryAttemptWasSpoiltIsSkipped) {
  attempts = 0;
  ::testing::TestPartResultArray found;
  {
    const ::testing::ScopedFakeTestPartResultReporter reporter(
        ::testing::ScopedFakeTestPartResultReporter::INTERCEPT_ONLY_CURRENT_THREAD, &found);
    Undisturbed(
        [] {
          ++attempts;
          FAIL();
        },
        [] { return true; }, 4);
  }
  EXPECT_EQ(attempts, 4);
  ASSERT_EQ(found.size(), 1);
  EXPECT_TRUE(found.GetTestPartResult(0).skipped());
}

}  // namespace
}  // namespace twin::test
