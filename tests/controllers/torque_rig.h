#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/panda_limits.h"
#include "twin/control/controller.h"
#include "twin/model/arm_model.h"
#include "twin/onboard/onboard_controller.h"
#include "twin/plant/mujoco_plant.h"

namespace twin::controllers::test {

/// The arm with INT, at rest, under a torque controller: one update a cycle, nothing lost.
class TorqueRig {
 public:
  explicit TorqueRig(const JointVector& q, std::vector<plant::Perturbation> perturbations = {},
                     plant::FrictionProfile friction = plant::FrictionProfile::kResidual) {
    plant::MujocoPlantOptions options;
    options.urdf = TWIN_SOURCE_DIR "/models/robots/panda/panda.urdf";
    options.hand = plant::HandKind::kNone;
    options.friction = friction;
    options.perturbations = std::move(perturbations);
    plant_ = plant::MujocoPlant::Create(options);
    plant_->Reset(q);
    onboard::OnboardConfig config;
    config.limits = twin::test::PandaLimits();
    config.cartesian = twin::test::PandaCartesianLimits();
    config.rotor_inertia = {0.605721456, 0.605721456, 0.462474144, 0.462474144,
                            0.205544064, 0.205544064, 0.205544064};
    // Who pushes on purpose means no collision.
    config.collision_behavior.upper_torque_acc.fill(1e3);
    config.collision_behavior.upper_torque_nominal.fill(1e3);
    config.collision_behavior.upper_force_acc.fill(1e3);
    config.collision_behavior.upper_force_nominal.fill(1e3);
    onboard_ = std::make_unique<onboard::OnboardController>(config, q);
    Cycle();
  }

  /// Runs a motion to its end. @param look  after each update: time since its begin.
  /// @returns the errors that ended it; "" when none did.
  std::string Run(control::Controller& controller,
                  const std::function<void(Duration, const control::ControllerOutput&)>& look) {
    controller.Activate(state_, Now());
    EXPECT_EQ(
        onboard_->Move({ControllerMode::kExternalController, MotionGeneratorMode::kJointVelocity}),
        MoveStatus::kMotionStarted);
    Cycle();
    control::ControllerOutput output;
    const Time start = Now();
    while (state_.robot_mode == RobotMode::kMove && Now() - start < std::chrono::seconds(60)) {
      controller.Update(state_, Now(), output);
      look(Now() - start, output);
      RobotCommand command;
      command.message_id = state_.message_id;
      command.tau_J_d = output.target.tau_J_d;
      command.motion_generation_finished = output.finished;
      Cycle(&command);
    }
    controller.Deactivate();
    return onboard_->last_end() == MoveStatus::kSuccess ? "" : FormatErrors(state_.errors);
  }

  [[nodiscard]] const RobotState& state() const { return state_; }
  [[nodiscard]] Transform O_T_EE() const {
    return model::ArmModel::Panda().Pose(model::Frame::kEndEffector, state_.q, state_.F_T_EE);
  }

 private:
  [[nodiscard]] Time Now() const { return Time(kCycle * state_.message_id); }
  void Cycle(const RobotCommand* command = nullptr) {
    plant_->Step(onboard_->Cycle(command, plant_->sensors()));
    onboard_->FillState(plant_->sensors(), state_);
  }

  std::unique_ptr<plant::MujocoPlant> plant_;
  std::unique_ptr<onboard::OnboardController> onboard_;
  RobotState state_;
};

}  // namespace twin::controllers::test
