// All of the planning problems in the clutter: what share is solved, what it takes, and whether
// each motion is free of contact by the engine itself.
#include <algorithm>
#include <cstdint>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "planning/problem_set.h"
#include "twin/core/clock.h"

namespace twin::planning::planning_problems_test {
namespace {

/// The value below which a share of the values lies.
double Quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

void Show(const char* what, const char* unit, const std::vector<double>& values) {
  fmt::print("  {:<16} median {:10.4g}  95 % {:10.4g}  most {:10.4g} {}\n", what,
             Quantile(values, 0.5), Quantile(values, 0.95), Quantile(values, 1), unit);
}

void SolveAll(const plant::MujocoPlantOptions& scene, std::uint64_t count) {
  CollisionWorld world(scene);
  EngineView engine(scene);
  const MonotonicClock clock;
  Planner planner(world, test::PandaLimits(), clock);
  std::vector<double> checks;
  std::vector<double> wall_ms;
  std::vector<double> duration_s;
  std::vector<double> length;
  double wall_s = 0;
  double all_checks = 0;
  for (std::uint64_t n = 0; n < count; ++n) {
    const Problem problem = ProblemOf(world, n);
    const PlanOutcome outcome = planner.ToConfiguration(problem.start, problem.goal, n);
    if (const auto* failure = std::get_if<PlanFailure>(&outcome)) {
      fmt::print("  problem {}: {}\n", n, failure->text);
      continue;
    }
    const Plan& plan = std::get<Plan>(outcome);
    EXPECT_EQ(FirstContact(engine, plan.trajectory, 0.08), std::nullopt) << "problem " << n;
    EXPECT_LE(plan.statistics.checks, 100'000) << "problem " << n;
    checks.push_back(static_cast<double>(plan.statistics.checks));
    wall_ms.push_back(ToSeconds(plan.statistics.wall) * 1e3);
    duration_s.push_back(ToSeconds(plan.trajectory.duration()));
    length.push_back(plan.statistics.path_length);
    all_checks += checks.back();
    wall_s += ToSeconds(plan.statistics.wall);
  }
  ASSERT_FALSE(checks.empty());
  fmt::print("{} of {} problems solved, {:.0f} checks/s\n", checks.size(), count,
             all_checks / wall_s);
  Show("checks", "", checks);
  Show("planning time", "ms", wall_ms);
  Show("motion", "s", duration_s);
  Show("path", "rad", length);
  EXPECT_GE(static_cast<double>(checks.size()), 0.98 * static_cast<double>(count));
}

TEST(PlanningProblemsTest, NearlyAllAreSolvedWithoutContact) {
  SolveAll(Options("clutter.xml"), 200);
}

TEST(PlanningProblemsTest, NearlyAllAreSolvedWithoutContactOfMeshes) {
  if (!HaveMeshes()) GTEST_SKIP() << "missing: the arm's meshes";
  SolveAll(MeshOptions("clutter.xml"), 200);
}

}  // namespace
}  // namespace twin::planning::planning_problems_test
