#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "controllers/registration.h"
#include "plugins/backends.h"
#include "twin/model/arm_model.h"
#include "twin/model/transform.h"
#include "twin/run/run.h"
#include "twin/scenario/robot_data.h"

namespace twin::run::test {

/// Whole lockstep runs that compare chains: how far the arm is from its plan.
namespace chain_runs {

using control::CommandInterface;

/// How fast the plan is. Of joints it is the brisk trajectory, at most 0.59 of the acceleration
/// limits and 0.8 of the speed limits, of poses the path of cartesian.yaml, at most 0.31 of the
/// speed limit of rotations; their times stretched.
struct Tempo {
  std::string_view name;
  double joints = 1;
  double poses = 1;
};
inline constexpr Tempo kGentle{"gentle", 2.5, 1};   // 0.1 of the acceleration; 0.31
inline constexpr Tempo kBrisk{"brisk", 1, 0.52};    // 0.59; 0.6
inline constexpr Tempo kHard{"hard", 0.81, 0.346};  // 0.9, and 0.99 of the speed; 0.9

/// A plan's deviation: the largest distance of the measured arm from where the plan is at that
/// instant, delay included.
struct Outcome {
  RunResult result;
  double deviation = 0;  ///< rad of a joint; of the pose interface m of the end effector
  double last = 0;       ///< the same in the last cycle

  [[nodiscard]] bool aborted() const { return !result.report.succeeded(); }
};

/// Compares each cycle with the plan at the same time.
class PlanWatch final : public record::RecordSink {
 public:
  PlanWatch(const reference::Trajectory& plan, const scenario::ControllerSection& source,
            bool as_pose)
      : plan_(plan), clock_rate_(1 + 1e-6 * source.clock_drift_ppm), as_pose_(as_pose) {}

  void Put(const record::CycleRecord& cycle) noexcept override {
    if (!begin_ || cycle.fate == record::CommandFate::kNone) return;
    const Duration since = cycle.at - *begin_;
    const auto t = Duration(std::llround(clock_rate_ * static_cast<double>(since.count())));
    last_ = Distance(cycle.state, plan_.Sample(t).q);
    largest_ = std::max(largest_, last_);
  }
  void Put(const record::TickRecord& tick) noexcept override {
    if (!begin_ && tick.deposit_time != Time()) begin_ = tick.deposit_time;
  }
  [[nodiscard]] double largest() const { return largest_; }
  [[nodiscard]] double last() const { return last_; }

 private:
  [[nodiscard]] double Distance(const RobotState& state, const JointVector& q) const {
    if (as_pose_) {
      const model::ArmModel& arm = model::ArmModel::Panda();
      const Transform O_T_EE =
          arm.Pose(model::Frame::kEndEffector, model::Configuration(q), state.F_T_EE);
      return (model::Position(O_T_EE) - model::Position(state.O_T_EE)).norm();
    }
    double most = 0;
    for (std::size_t i = 0; i < kJoints; ++i) most = std::max(most, std::abs(q[i] - state.q[i]));
    return most;
  }

  const reference::Trajectory& plan_;
  double clock_rate_;
  bool as_pose_;
  std::optional<Time> begin_;
  double largest_ = 0;
  double last_ = 0;
};

class Bench {
 public:
  Bench() {
    plugins::RegisterMujoco(backends_);
    controllers::RegisterControllers(controllers_);
  }

  /// By a loop without jitter or loss, with the chain that a scenario has by default; on the ideal
  /// plant, under torques on the simulated one.
  [[nodiscard]] scenario::Scenario Make(CommandInterface interface, const Tempo& tempo) const {
    scenario::Scenario scenario = scenario::Load(models_ / "scenarios" / "brisk.yaml");
    const bool by_torque = interface == CommandInterface::kTorque;
    scenario.tick = by_torque ? scenario::TorqueTick() : scenario::TickSection();
    scenario.tick.cost = {faults::ConstantDelay{std::chrono::microseconds(13)}};
    scenario.record = false;
    if (!by_torque) scenario.plant.kind = robot::PlantKind::kIdeal;
    if (by_torque) {
      scenario.controller.type = "joint_trajectory_effort";
      scenario.onboard.friction_compensation = 0.8;
    }
    const bool as_poses = interface == CommandInterface::kCartesianPose;
    if (as_poses) scenario.motion = scenario::Load(models_ / "scenarios" / "cartesian.yaml").motion;
    scenario.motion.interface = interface;
    scenario.motion.timing.duration.reset();
    for (reference::Waypoint& waypoint : scenario.motion.waypoints) {
      const double stretch = as_poses ? tempo.poses : tempo.joints;
      waypoint.at = FromSeconds(ToSeconds(*waypoint.at) * stretch);
    }
    return scenario;
  }
  [[nodiscard]] scenario::Scenario Canonical() const {
    scenario::Scenario scenario = scenario::Load(models_ / "scenarios" / "canonical.yaml");
    scenario.record = false;
    scenario.plant.kind = robot::PlantKind::kIdeal;
    return scenario;
  }

  [[nodiscard]] Outcome Run(const scenario::Scenario& scenario) const {
    const bool as_pose = scenario.motion.interface == CommandInterface::kCartesianPose;
    const reference::Trajectory plan = MakeTrajectory(
        scenario, scenario::LoadRobotData(models_, scenario.robot.model, scenario.robot.hand));
    PlanWatch watch(plan, scenario.controller, as_pose);
    run::Run run(scenario, {backends_, controllers_}, {models_, {}, {}, false}, &watch);
    Outcome outcome{.result = run.Execute()};
    outcome.deviation = watch.largest();
    outcome.last = watch.last();
    return outcome;
  }

 private:
  const std::filesystem::path models_ = std::filesystem::path(TWIN_SOURCE_DIR) / "models";
  backend::Registry backends_;
  control::ControllerRegistry controllers_;
};

/// Bursts of `length` lost commands, every 0.6 s from 0.3 s on.
inline scenario::Loss BurstsOf(std::uint64_t length) {
  scenario::ScriptedLoss script;
  for (int ms = 300; ms < 20000; ms += 600) {
    script.bursts.push_back({std::chrono::milliseconds(ms), length});
  }
  return {script};
}

/// `share` of the wake-ups late, by up to `most`, evenly.
inline scenario::Delay LateWakes(double share, Duration most) {
  return {faults::EmpiricalDelay{{Duration::zero(), std::chrono::microseconds(20), most},
                                 {1 - share, share}}};
}

}  // namespace chain_runs
}  // namespace twin::run::test
