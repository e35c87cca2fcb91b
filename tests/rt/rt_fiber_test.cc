#include "twin/rt/fiber.h"

#include <deque>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/realtime_guard.h"

namespace twin::rt {
namespace {

TEST(FiberTest, TakesTurnsWithItsOwner) {
  std::string order;
  Fiber fiber([&order] {
    order += "a";
    Fiber::Yield();
    order += "b";
  });
  order += "0";
  fiber.Resume();
  order += "1";
  EXPECT_FALSE(fiber.ended());
  fiber.Resume();
  EXPECT_EQ(order, "0a1b");
  EXPECT_TRUE(fiber.ended());
}

TEST(FiberTest, GivesItsExceptionToTheResumeInWhichItEnds) {
  Fiber fiber([] {
    Fiber::Yield();
    throw std::runtime_error("ended badly");
  });
  fiber.Resume();
  EXPECT_THROW(fiber.Resume(), std::runtime_error);
  EXPECT_TRUE(fiber.ended());
}

/// Yields while its destructor runs, which an exception may call.
struct YieldsAtTheEnd {
  ~YieldsAtTheEnd() { Fiber::Yield(); }
};

TEST(FiberTest, KeepsExceptionsOfTwoFibersApart) {
  std::vector<std::string> caught;
  const auto throws = [&caught](const char* what) {
    return [&caught, what] {
      try {
        const YieldsAtTheEnd yields;
        throw std::runtime_error(what);
      } catch (const std::runtime_error& error) {
        Fiber::Yield();
        caught.emplace_back(error.what());
      }
    };
  };
  Fiber first(throws("first"));
  Fiber second(throws("second"));
  while (!first.ended() || !second.ended()) {
    if (!first.ended()) first.Resume();
    EXPECT_EQ(std::uncaught_exceptions(), 0);
    EXPECT_EQ(std::current_exception(), nullptr);
    if (!second.ended()) second.Resume();
  }
  EXPECT_EQ(caught, (std::vector<std::string>{"first", "second"}));
}

TEST(FiberTest, ResumesInTurnUntilAllHaveEnded) {
  std::string order;
  std::deque<Fiber> fibers;
  for (const int times : {1, 3, 2}) {
    fibers.emplace_back([&order, times] {
      for (int i = 1; i <= times; ++i) {
        order += static_cast<char>('0' + times);
        if (i < times) Fiber::Yield();
      }
    });
  }
  ResumeInTurn(fibers);
  EXPECT_EQ(order, "132323");
}

TEST(FiberTest, RunsInAFiber) {
  int steps = 0;
  Fiber outer([&steps] {
    Fiber inner([&steps] {
      ++steps;
      Fiber::Yield();
      ++steps;
    });
    inner.Resume();
    Fiber::Yield();
    inner.Resume();
  });
  outer.Resume();
  EXPECT_EQ(steps, 1);
  outer.Resume();
  EXPECT_EQ(steps, 2);
  EXPECT_TRUE(outer.ended());
}

TEST(FiberTest, SwitchesWithoutAllocation) {
  bool ends = false;
  Fiber fiber([&ends] {
    while (!ends) Fiber::Yield();
  });
  fiber.Resume();
  {
    const test::RealtimeGuard guard;
    for (int i = 0; i < 1000; ++i) fiber.Resume();
    EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts());
  }
  ends = true;
  fiber.Resume();
  EXPECT_TRUE(fiber.ended());
}

}  // namespace
}  // namespace twin::rt
