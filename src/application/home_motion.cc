#include "application/home_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "twin/backend/hand.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/planning/planner.h"
#include "twin/run/robot_config.h"

namespace twin::application {
namespace {

/// Shares of the limits: slow enough to be watched and stopped.
constexpr reference::Timing kSlow{
    .velocity_scale = 0.1, .acceleration_scale = 0.05, .jerk_scale = 0.05};
constexpr double kIsThere = 0.001;  // rad

planning::Plan PlanHome(planning::CollisionWorld& world, const run::Session& session,
                        const JointVector& start, const JointVector& home) {
  const MonotonicClock clock;
  planning::Planner planner(world, session.robot().limits, clock, {.pace = kSlow});
  planning::PlanOutcome outcome = planner.ToConfiguration(start, home, 1);
  if (auto* plan = std::get_if<planning::Plan>(&outcome)) return std::move(*plan);
  throw RobotFault(fmt::format("no way home: {}", std::get<planning::PlanFailure>(outcome).text));
}

}  // namespace

void MoveHome(run::Session& session, const scenario::Scenario& led,
              const scenario::Scenario& served, const run::RunFiles& files,
              const PageOperator::Arrange& arrange) {
  const JointVector start = session.ReadState().q_d;
  const JointVector home = led.robot.q_start.value();
  const bool is_there = std::ranges::equal(
      start, home, [](double a, double b) { return std::abs(a - b) < kIsThere; });
  if (is_there) {
    session.Tell("home", "the arm is there");
    return;
  }
  const auto world = run::MakeWorld(served, session.robot(), files);
  if (backend::Hand* hand = session.connection().hand; hand != nullptr) {
    const HandState state = hand->ReadState();
    if (state.is_grasped) {
      throw RobotFault(
          "no way home: the hand holds something whose shape the planner does not know; open it");
    }
    world->SetHandWidth(std::clamp(state.width, 0.0, kHandStroke));
  }
  arrange(*world);
  const planning::Plan plan = PlanHome(*world, session, start, home);
  session.Tell("home",
               fmt::format("moves there in {:.1f} s", ToSeconds(plan.trajectory.duration())));
  const run::MotionResult result = session.Move(
      run::MotionOn(led, "home", control::CommandInterface::kJointPosition, plan.trajectory));
  if (!result.report.succeeded()) {
    throw RobotFault(fmt::format("the way home ended early: {}", result.report.failure));
  }
  session.Tell("home", "reached");
}

}  // namespace twin::application
