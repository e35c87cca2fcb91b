#include "twin/run/work_pool.h"

#include <atomic>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "run/stepped_fixture.h"
#include "support/bits.h"
#include "twin/core/error.h"

namespace twin::run::run_work_pool_test {
namespace {

TEST(WorkPoolTest, DoesEachPieceOnceWithAnyNumberOfThreads) {
  for (const int threads : {1, 2, 5}) {
    WorkPool pool(threads);
    for (int round = 0; round < 200; ++round) {
      std::vector<std::atomic<int>> done(7);
      pool.ForEach(done.size(), [&](std::size_t i) { ++done[i]; });
      for (const std::atomic<int>& count : done) EXPECT_EQ(count, 1);
    }
  }
}

TEST(WorkPoolTest, ThrowsTheFirstPiecesExceptionAfterAllHaveEnded) {
  WorkPool pool(3);
  std::atomic<int> ended = 0;
  const auto work = [&](std::size_t i) {
    ++ended;
    if (i >= 4) throw std::runtime_error(std::to_string(i));
  };
  EXPECT_THAT([&] { pool.ForEach(8, work); },
              ::testing::ThrowsMessage<std::runtime_error>(::testing::StrEq("4")));
  EXPECT_EQ(ended, 8);
  pool.ForEach(3, work);
  EXPECT_EQ(ended, 11);
}

TEST(WorkPoolTest, RefusesToWorkWithoutThreads) {
  EXPECT_THROW(WorkPool(0), InputError);
}

TEST(WorkPoolTest, StepsRobotsToTheSameBitsWithAnyNumberOfThreads) {
  std::vector<std::vector<std::uint64_t>> results;
  for (const int threads : {1, 3}) {
    std::vector<std::unique_ptr<SteppedRobot>> robots(4);
    WorkPool pool(threads);
    std::vector<std::uint64_t> bits;
    pool.ForEach(robots.size(), [&](std::size_t i) {
      robots[i] = std::make_unique<SteppedRobot>(twin::test::Stepped(twin::test::kLossy),
                                                 twin::test::Files());
      robots[i]->Reset({.seed = i});
    });
    for (int step = 0; step < 5; ++step) {
      pool.ForEach(robots.size(), [&](std::size_t i) {
        reference::Target target;
        target.pose.O_T_EE = twin::test::PoseOf(robots[i]->report());
        target.pose.O_T_EE[12] += 0.01 * static_cast<double>(i);
        robots[i]->SetTarget(target);
        robots[i]->Advance(20);
      });
    }
    for (const auto& robot : robots) {
      const auto row = twin::test::Bits(robot->report());
      bits.insert(bits.end(), row.begin(), row.end());
    }
    results.push_back(bits);
  }
  EXPECT_EQ(results[0], results[1]);
}

}  // namespace
}  // namespace twin::run::run_work_pool_test
