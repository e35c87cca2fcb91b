// 200 random problems in the clutter, planned and executed: what share is solved, what is touched,
// how far the arm is from its target.
#include <algorithm>
#include <cstdint>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "run/plan_execution.h"

namespace twin::run::run_plans_test {
namespace {

void Show(const char* what, const char* unit, std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const auto quantile = [&values](double share) {
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
  };
  fmt::print("  {:<16} median {:10.4g}  95 % {:10.4g}  most {:10.4g} {}\n", what, quantile(0.5),
             quantile(0.95), quantile(1), unit);
}

TEST(PlanRunsTest, NearlyAllAreSolvedAndNoneTouchesAnything) {
  constexpr std::uint64_t kProblems = 200;
  test::Problems problems;
  std::vector<double> checks;
  std::vector<double> planning_ms;
  std::vector<double> motion_s;
  std::vector<double> off;
  std::vector<double> final_error;
  double all_checks = 0;
  double all_s = 0;
  for (std::uint64_t n = 0; n < kProblems; ++n) {
    const test::Outcome outcome = problems.Execute(problems.Problem(n));
    if (!outcome.is_solved) {
      fmt::print("  problem {}: {}\n", n, outcome.unsolved);
      continue;
    }
    EXPECT_TRUE(outcome.result.report.succeeded()) << n << ": " << outcome.result.report.failure;
    EXPECT_EQ(outcome.touched, 0u) << n << ": " << outcome.touch;
    checks.push_back(static_cast<double>(outcome.result.plan->checks));
    planning_ms.push_back(outcome.planning_s * 1e3);
    motion_s.push_back(ToSeconds(outcome.result.plan->duration));
    off.push_back(outcome.off);
    final_error.push_back(outcome.result.final_error);
    all_checks += checks.back();
    all_s += outcome.planning_s;
  }
  ASSERT_FALSE(checks.empty());
  fmt::print("{} of {} problems solved, {:.0f} checks/s\n", checks.size(), kProblems,
             all_checks / all_s);
  Show("checks", "", checks);
  Show("planning time", "ms", planning_ms);
  Show("motion", "s", motion_s);
  Show("off the target", "rad", off);
  Show("final error", "rad", final_error);
  EXPECT_GE(static_cast<double>(checks.size()), 0.98 * static_cast<double>(kProblems));
}

}  // namespace
}  // namespace twin::run::run_plans_test
