// The tracepoints by themselves, also under scripts/trace (tests/cli/trace_test.py), where LTTng
// records them.
#include "loop/trace_points.h"

#include <cstdint>
#include <thread>

#include <gtest/gtest.h>

#include "support/realtime_guard.h"

namespace twin::loop::loop_trace_points_test {
namespace {

void TraceCycle(std::uint64_t message_id) {
  TraceReadBegin(message_id - 1);
  TraceStateRead(message_id);
  TraceWriteBegin(message_id);
  TraceWriteEnd(message_id);
}

TEST(TracePointsTest, AfterTheFirstEventNoneAllocatesFreesOrLocks) {
  test::RealtimeGuard::Counts counts{.allocations = -1};
  // The main thread is known to LTTng from the start; another one is not.
  std::thread([&counts] {
    TraceReadBegin(0);
    const test::RealtimeGuard guard;
    for (std::uint64_t id = 1; id <= 1000; ++id) TraceCycle(id);
    counts = guard.counts();
  }).join();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
}

}  // namespace
}  // namespace twin::loop::loop_trace_points_test
