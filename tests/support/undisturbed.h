#pragma once

#include <functional>
#include <string_view>

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include "twin/core/error.h"

namespace twin::test {

/// What errors of programs on the wall clock say of a machine that did not run a thread.
inline constexpr std::string_view kBlamesTheMachine = "this machine gives it no time";

/// For promises that hold on the wall clock as long as the machine keeps the threads running.
///
/// Runs `attempt` with its failures held back. An attempt without one ends it. One that failed
/// because of the machine is repeated; any other failure is the test's. When the machine spoilt
/// every attempt the test is skipped. The machine is the cause when `spoilt` says so, or when the
/// failure or an exception blames it in its text.
///
/// @param attempt  makes what it needs anew; its assertions are on the calling thread.
/// @param spoilt   asked after an attempt that failed: whether the machine disturbed it.
inline void Undisturbed(
    const std::function<void()>& attempt,
    const std::function<bool()>& spoilt = [] { return false; }, int attempts = 10) {
  const auto blames = [](std::string_view text) {
    return text.find(kBlamesTheMachine) != std::string_view::npos;
  };
  for (int i = 0; i < attempts; ++i) {
    bool failed = false;
    bool blamed = false;
    ::testing::TestPartResultArray found;
    {
      const ::testing::ScopedFakeTestPartResultReporter reporter(
          ::testing::ScopedFakeTestPartResultReporter::INTERCEPT_ONLY_CURRENT_THREAD, &found);
      try {
        attempt();
      } catch (const Error& error) {
        failed = true;
        blamed = blames(error.what());
        if (!blamed && !spoilt()) throw;
      }
    }
    for (int part = 0; part < found.size(); ++part) {
      failed = failed || found.GetTestPartResult(part).failed();
      blamed = blamed || blames(found.GetTestPartResult(part).message());
    }
    if (!failed) return;
    if (blamed || spoilt()) continue;
    for (int part = 0; part < found.size(); ++part) {
      const ::testing::TestPartResult& result = found.GetTestPartResult(part);
      if (result.failed()) {
        ADD_FAILURE_AT(result.file_name(), result.line_number()) << result.message();
      }
    }
    return;
  }
  GTEST_SKIP() << "this machine disturbed every attempt";
}

}  // namespace twin::test
