#include "run/resolve.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/core/hand_command.h"
#include "twin/model/arm_model.h"
#include "twin/model/transform.h"
#include "twin/planning/random_goal.h"
#include "twin/plant/observers.h"
#include "twin/run/plan_to.h"
#include "twin/run/robot_config.h"
#include "twin/run/run.h"

namespace twin::run {
namespace {

/// Plans to whatever the goal is.
class Question {
 public:
  Question(const scenario::Scenario& scenario, const scenario::RobotData& robot,
           const JointVector& start, planning::CollisionWorld& world, const Clock& clock)
      : plan_(*scenario.motion.plan),
        q_start_(*scenario.robot.q_start),
        start_(start),
        seed_(plan_.seed.value_or(scenario.seed)),
        robot_(robot),
        F_T_EE_(robot.F_T_EE(scenario.onboard.NE_T_EE)),
        world_(world),
        planner_(world, robot.limits, clock,
                 {.most_checks = plan_.budget,
                  .clearance = plan_.clearance,
                  .pace = scenario.motion.timing}) {}

  [[nodiscard]] planning::PlanOutcome Answer() {
    return std::visit([this](const auto& goal) { return To(goal); }, plan_.goal);
  }

 private:
  [[nodiscard]] planning::PlanOutcome To(const scenario::RandomGoal& /*goal*/) {
    return To(planning::RandomGoal(world_, robot_.limits, seed_,
                                   {.from = q_start_, .clearance = plan_.clearance}));
  }
  [[nodiscard]] planning::PlanOutcome To(const JointVector& q) {
    return planner_.ToConfiguration(start_, q, seed_);
  }
  [[nodiscard]] planning::PlanOutcome To(const scenario::FramePose& O_T_EE) {
    return planner_.ToPose(start_, model::Multiply(O_T_EE.Matrix(), model::Inverse(F_T_EE_)),
                           seed_);
  }

  const scenario::PlanSection& plan_;
  const JointVector q_start_;  ///< where the arm should stand
  const JointVector start_;    ///< where it does
  const std::uint64_t seed_;
  const scenario::RobotData& robot_;
  const Transform F_T_EE_;
  planning::CollisionWorld& world_;
  planning::Planner planner_;
};

/// "s.yaml:12: ", where it was read from a file.
std::string PlaceOf(const scenario::PlanSection& plan) {
  return plan.where.empty() ? "" : plan.where + ": ";
}

reference::Trajectory Stretched(planning::Plan plan, double by, const JointLimits& limits) {
  if (by == 1) return std::move(plan.trajectory);
  for (reference::Waypoint& point : plan.waypoints) {
    point.at = FromSeconds(ToSeconds(point.at.value()) * by);
  }
  return reference::Trajectory(plan.waypoints, {}, limits);
}

}  // namespace

reference::Trajectory PlanMotion(const scenario::Scenario& scenario,
                                 const scenario::RobotData& robot, const JointVector& start,
                                 const RunFiles& files, planning::PlanStatistics& statistics) {
  const scenario::PlanSection& plan = *scenario.motion.plan;
  const MonotonicClock clock;
  try {
    const auto around = MakeWorld(scenario, robot, files);
    planning::PlanOutcome outcome = Question(scenario, robot, start, *around, clock).Answer();
    if (auto* found = std::get_if<planning::Plan>(&outcome)) {
      statistics = found->statistics;
      const double needed = EndEffectorStretch(scenario, robot, found->trajectory);
      reference::Trajectory trajectory =
          Stretched(std::move(*found), plan.stretch * needed, robot.limits);
      statistics.duration = trajectory.duration();
      return trajectory;
    }
    const auto& failure = std::get<planning::PlanFailure>(outcome);
    if (failure.reason == planning::PlanFailureReason::kBudgetExhausted) {
      throw NoPlanError(PlaceOf(plan) + failure.text);
    }
    throw InputError(failure.text);
  } catch (const InputError& error) {
    throw InputError(PlaceOf(plan) + error.what());
  }
}

namespace {

/// The free body that the fingers touch, nearest first; empty: none.
std::string HeldBody(planning::CollisionWorld& world, const JointVector& q,
                     const std::vector<std::pair<std::string, Transform>>& bodies) {
  constexpr double kTouch = 2e-3;
  for (const planning::Touch& touch : world.Touches(q, kTouch)) {
    const bool by_hand = touch.a.find("finger") != std::string_view::npos ||
                         touch.a.find("cup") != std::string_view::npos;
    for (const auto& [name, pose] : bodies) {
      if (by_hand && touch.b == name) return name;
    }
  }
  return {};
}

void ArrangeAsNow(const Session& session, const RobotState& state,
                  planning::CollisionWorld& world) {
  world.Detach();
  if (const plant::TruthProbe* truth = session.connection().truth) {
    const plant::TruthProbe& scene = truth->whole();
    world.ArrangeAs(scene.model(), plant::PositionsOf(scene));
  }
  const backend::Hand* hand = session.connection().hand;
  if (hand == nullptr) return;
  const HandState now = hand->ReadState();
  world.SetHandWidth(std::clamp(now.width, 0.0, kHandStroke));
  if (!now.is_grasped) return;
  const auto bodies = session.Bodies();
  const std::string held = HeldBody(world, state.q_d, bodies);
  if (held.empty()) return;
  const Transform O_T_F = model::ArmModel::Panda().Pose(model::Frame::kFlange, state.q);
  const auto body = std::ranges::find(bodies, held, &std::pair<std::string, Transform>::first);
  world.Attach(held, model::Multiply(model::Inverse(O_T_F), body->second));
}

}  // namespace

planning::Plan PlanTo(const Session& session, planning::CollisionWorld& world,
                      const JointVector& goal, std::uint64_t seed,
                      const planning::PlannerOptions& options) {
  const RobotState state = session.Peek();
  ArrangeAsNow(session, state, world);
  const MonotonicClock clock;
  planning::Planner planner(world, session.robot().limits, clock, options);
  planning::PlanOutcome outcome = planner.ToConfiguration(state.q_d, goal, seed);
  if (auto* found = std::get_if<planning::Plan>(&outcome)) return std::move(*found);
  const auto& failure = std::get<planning::PlanFailure>(outcome);
  if (failure.reason == planning::PlanFailureReason::kBudgetExhausted) {
    throw NoPlanError(failure.text);
  }
  throw InputError(failure.text);
}

void RequireFree(const scenario::Scenario& scenario, const RunFiles& files) {
  constexpr Duration kStep = std::chrono::milliseconds(2);
  const scenario::MotionSection& motion = scenario.motion;
  const bool drives = scenario.base && !scenario.base->drive.empty();
  if (!motion.touches.empty() || motion.waypoints.size() < 2 || drives) return;
  const scenario::RobotData robot =
      scenario::LoadRobotData(files.models, scenario.robot.model, scenario.robot.hand);
  const reference::Trajectory trajectory = MakeTrajectory(scenario, robot);
  planning::CollisionWorld world(MakeRobotConfig(scenario, robot, files).plant);
  for (Duration t{}; t < trajectory.duration() + kStep; t += kStep) {
    const std::vector<planning::Touch> touches = world.Touches(trajectory.Sample(t).q);
    if (touches.empty()) continue;
    throw InputError(
        fmt::format("motion: at {:.3f} s of {:.3f} s {}; move the waypoints, or say why the arm "
                    "may touch it (motion.touches, --no-collision-check)",
                    ToSeconds(t), ToSeconds(trajectory.duration()), planning::Describe(touches)));
  }
}

}  // namespace twin::run
