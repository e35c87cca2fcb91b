// The effort controller on the arm: INT and the MuJoCo plant, one update a cycle, nothing lost.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "controllers/joint_trajectory_effort.h"
#include "support/panda_limits.h"
#include "twin/onboard/onboard_controller.h"
#include "twin/plant/mujoco_plant.h"

namespace twin::controllers::controllers_joint_trajectory_effort_motion_test {
namespace {

using plant::FrictionProfile;
using reference::Trajectory;

/// models/scenarios/trajectories/canonical.yaml; `offset` is added to joint 1.
Trajectory Canonical(double offset = 0) {
  const YAML::Node file =
      YAML::LoadFile(TWIN_SOURCE_DIR "/models/scenarios/trajectories/canonical.yaml");
  std::vector<reference::Waypoint> waypoints;
  for (const YAML::Node& point : file["waypoints"]) {
    waypoints.push_back({.q = point["q"].as<JointVector>(),
                         .at = FromSeconds(std::stod(point["at"].as<std::string>()))});
    waypoints.back().q[0] += offset;
  }
  return Trajectory(waypoints, {}, twin::test::PandaLimits());
}

/// What a motion came to.
struct Outcome {
  MoveStatus end = MoveStatus::kMotionStarted;
  std::string errors;
  double most_torque_rate = 0;      ///< of the commands, against the reported torque, Nm/s
  double most_error = 0;            ///< |q* - q| of any joint, rad
  double final_speed = 0;           ///< of any joint in the state before `finished`, rad/s
  std::optional<Duration> settled;  ///< from the path's end to `finished`
  JointVector final_error{};        ///< goal - q, one second after the end
};

/// The arm, at rest at `q`.
class Arm {
 public:
  Arm(FrictionProfile friction, const JointVector& q) {
    plant::MujocoPlantOptions options;
    options.urdf = TWIN_SOURCE_DIR "/models/robots/panda/panda.urdf";
    options.hand = plant::HandKind::kNone;
    options.friction = friction;
    plant_ = plant::MujocoPlant::Create(options);
    plant_->Reset(q);
    onboard::OnboardConfig config;
    config.limits = twin::test::PandaLimits();
    config.cartesian = twin::test::PandaCartesianLimits();
    config.rotor_inertia = {0.605721456, 0.605721456, 0.462474144, 0.462474144,
                            0.205544064, 0.205544064, 0.205544064};
    // Dry friction looks like a collision to a robot that does not expect it.
    config.collision_behavior.upper_torque_acc.fill(1e3);
    config.collision_behavior.upper_torque_nominal.fill(1e3);
    config.collision_behavior.upper_force_acc.fill(1e3);
    config.collision_behavior.upper_force_nominal.fill(1e3);
    onboard_ = std::make_unique<onboard::OnboardController>(config, q);
  }

  void Cycle(const RobotCommand* command = nullptr) {
    plant_->Step(onboard_->Cycle(command, plant_->sensors()));
    onboard_->FillState(plant_->sensors(), state_);
  }

  Outcome Run(JointTrajectoryEffortController& controller, const Trajectory& trajectory) {
    Outcome outcome;
    Cycle();
    controller.Activate(state_, Now());
    EXPECT_EQ(
        onboard_->Move({ControllerMode::kExternalController, MotionGeneratorMode::kJointVelocity}),
        MoveStatus::kMotionStarted);
    Cycle();
    control::ControllerOutput output;
    const Time start = Now();
    while (state_.robot_mode == RobotMode::kMove && Now() - start < std::chrono::seconds(30)) {
      controller.Update(state_, Now(), output);
      Observe(output, trajectory, Now() - start, outcome);
      RobotCommand command;
      command.message_id = state_.message_id;
      command.tau_J_d = output.target.tau_J_d;
      command.motion_generation_finished = output.finished;
      Cycle(&command);
    }
    outcome.end = onboard_->last_end();
    outcome.errors = FormatErrors(state_.errors);
    for (int i = 0; i < 1000; ++i) Cycle();
    for (std::size_t j = 0; j < kJoints; ++j) {
      outcome.final_error[j] = trajectory.goal()[j] - state_.q[j];
    }
    return outcome;
  }

  [[nodiscard]] const RobotState& state() const { return state_; }

 private:
  [[nodiscard]] Time Now() const { return Time(kCycle * state_.message_id); }

  void Observe(const control::ControllerOutput& output, const Trajectory& trajectory,
               Duration elapsed, Outcome& outcome) const {
    if (outcome.settled) return;
    if (output.finished) outcome.settled = elapsed - trajectory.duration();
    outcome.final_speed = 0;
    for (std::size_t j = 0; j < kJoints; ++j) {
      const double rate = std::abs(output.target.tau_J_d[j] - state_.tau_J_d[j]) / kCycleSeconds;
      outcome.most_torque_rate = std::max(outcome.most_torque_rate, rate);
      const double error = std::abs(output.target.joint.q[j] - state_.q[j]);
      outcome.most_error = std::max(outcome.most_error, error);
      outcome.final_speed = std::max(outcome.final_speed, std::abs(state_.dq[j]));
    }
  }

  std::unique_ptr<plant::MujocoPlant> plant_;
  std::unique_ptr<onboard::OnboardController> onboard_;
  RobotState state_;
};

void Print(const Outcome& outcome) {
  std::printf(
      "torque rate up to %.1f Nm/s, error up to %.5f rad, settled %.0f ms after the path at "
      "%.5f rad/s\n",
      outcome.most_torque_rate, outcome.most_error,
      ToSeconds(outcome.settled.value_or(Duration::zero())) * 1e3, outcome.final_speed);
}

class JointTrajectoryEffortFrictionTest : public testing::TestWithParam<FrictionProfile> {};

TEST_P(JointTrajectoryEffortFrictionTest, FollowsTheCanonicalTrajectoryAndEndsAtRest) {
  const Trajectory trajectory = Canonical();
  JointTrajectoryEffortController controller(trajectory);
  Arm arm(GetParam(), trajectory.start());
  const Outcome outcome = arm.Run(controller, trajectory);
  Print(outcome);
  EXPECT_EQ(outcome.end, MoveStatus::kSuccess) << outcome.errors;
  EXPECT_LT(outcome.most_torque_rate, 200) << "a fifth of what the robot takes";
  EXPECT_LT(outcome.most_error, 0.02);
  ASSERT_TRUE(outcome.settled.has_value());
  EXPECT_LT(*outcome.settled, std::chrono::milliseconds(500)) << "settled, not given up";
  EXPECT_LE(outcome.final_speed, 0.01);
  for (const double error : outcome.final_error) EXPECT_LE(std::abs(error), 0.011);
  for (const double dq : arm.state().dq) EXPECT_NEAR(dq, 0, 1e-4);
}

TEST(JointTrajectoryEffortMotionTest, TakesInAStartOffThePathWithoutATorqueStep) {
  const Trajectory trajectory = Canonical(0.0199);  // 12 Nm by the law
  JointTrajectoryEffortController controller(trajectory);
  JointVector q = trajectory.start();
  q[0] -= 0.0199;
  Arm arm(FrictionProfile::kResidual, q);
  const Outcome outcome = arm.Run(controller, trajectory);
  Print(outcome);
  EXPECT_EQ(outcome.end, MoveStatus::kSuccess) << outcome.errors;
  EXPECT_LT(outcome.most_torque_rate, 200);
}

TEST(JointTrajectoryEffortMotionTest, RunsOneMotionAfterAnotherAgainstDryFriction) {
  const Trajectory trajectory = Canonical();
  JointTrajectoryEffortController controller(trajectory);
  Arm arm(FrictionProfile::kBreakaway, trajectory.start());
  for (int motion = 0; motion < 2; ++motion) {
    const Outcome outcome = arm.Run(controller, trajectory);
    Print(outcome);
    EXPECT_EQ(outcome.end, MoveStatus::kSuccess) << outcome.errors;
    controller.Deactivate();
  }
}

INSTANTIATE_TEST_SUITE_P(EveryFriction, JointTrajectoryEffortFrictionTest,
                         testing::Values(FrictionProfile::kNone, FrictionProfile::kResidual,
                                         FrictionProfile::kBreakaway));

}  // namespace
}  // namespace twin::controllers::controllers_joint_trajectory_effort_motion_test
