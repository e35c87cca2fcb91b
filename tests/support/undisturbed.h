#pragma once

#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <limits>
#include <memory>

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include "support/witness.h"
#include "twin/core/error.h"

namespace twin::test {

/// How many cycles in a row the host must have spoilt to make what failed.
inline constexpr std::int64_t kAnyLoss = 1;       ///< a claim about consecutive cycles
inline constexpr std::int64_t kEndsAMotion = 20;  ///< communication_constraints_violation
inline constexpr std::int64_t kGivenUp = 900;     ///< a thread did not run for 1 s
inline constexpr std::int64_t kNothingExcuses = std::numeric_limits<std::int64_t>::max();

/// Begins to watch the host; what it returns ends that, and says what was seen.
using WatchHost = std::function<std::function<Lateness()>()>;

/// By a Witness of this priority: the least of the attempt's own threads.
inline WatchHost ByWitness(int fifo_priority) {
  return [fifo_priority] {
    return [witness = std::make_shared<Witness>(fifo_priority)] { return witness->End(); };
  };
}

/// For promises that hold on the wall clock as long as the host runs the threads.
///
/// Runs `attempt` with its failures held back, beside a witness of the host's lateness. An attempt
/// without a failure ends it. One that failed while the host spoilt at least `needed()` cycles in a
/// row is repeated; any other failure is the test's, whatever it says. When the host spoilt every
/// attempt, the test is skipped.
///
/// @param attempt  makes what it needs anew; its assertions are on the calling thread.
/// @param needed   asked after an attempt that failed: one of the above, or as many.
inline void Undisturbed(
    const std::function<void()>& attempt,
    const std::function<std::int64_t()>& needed = [] { return kGivenUp; },
    const WatchHost& watch = ByWitness(0), int attempts = 10) {
  Lateness seen;
  for (int i = 0; i < attempts; ++i) {
    const std::function<Lateness()> end_watch = watch();
    std::exception_ptr error;
    ::testing::TestPartResultArray found;
    {
      const ::testing::ScopedFakeTestPartResultReporter reporter(
          ::testing::ScopedFakeTestPartResultReporter::INTERCEPT_ONLY_CURRENT_THREAD, &found);
      try {
        attempt();
      } catch (const Error&) {
        error = std::current_exception();
      }
    }
    bool failed = error != nullptr;
    for (int part = 0; part < found.size(); ++part) {
      failed = failed || found.GetTestPartResult(part).failed();
    }
    if (!failed) return;
    seen = end_watch();
    if (seen.spoilt_in_row >= needed()) continue;
    for (int part = 0; part < found.size(); ++part) {
      const ::testing::TestPartResult& result = found.GetTestPartResult(part);
      if (!result.failed()) continue;
      ADD_FAILURE_AT(result.file_name(), result.line_number())
          << result.message() << "\n(the host spoilt " << seen.spoilt_in_row << " cycles in a row)";
    }
    if (error) std::rethrow_exception(error);
    return;
  }
  GTEST_SKIP() << "this host spoilt each of " << attempts << " attempts: in the last "
               << seen.spoilt_in_row << " cycles in a row, by up to "
               << std::chrono::duration<double, std::milli>(seen.most).count() << " ms";
}

}  // namespace twin::test
