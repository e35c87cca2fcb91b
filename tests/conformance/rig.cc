#include "conformance/rig.h"

#include <stdexcept>
#include <utility>

#include "twin/core/error.h"

namespace twin::test {

Rig::Rig(std::unique_ptr<BackendHarness> harness, const robot::RobotConfig& robot, bool checked)
    : harness_(std::move(harness)) {
  if (checked) checker_.emplace(ToCheck(robot), [this] { return Describe(); });
  Cycle();
}

template <typename Request>
bool Rig::Try(Request request) {
  try {
    request();
  } catch (const Error& error) {
    refusal_ = error.what();
    return false;
  }
  return true;
}

bool Rig::Start(const MotionModes& modes) {
  const bool accepted = Try([&] { harness_->backend().Start(modes); });
  if (checker_) checker_->OnStart(modes, accepted);
  return accepted;
}

bool Rig::Recover() {
  const bool accepted = Try([&] { harness_->backend().Recover(); });
  if (checker_) checker_->OnRequest(Ask::kAutomaticErrorRecovery, accepted);
  return accepted;
}

bool Rig::Configure(const Setting& setting) {
  const bool accepted = Try([&] { harness_->backend().Configure(setting); });
  if (checker_) checker_->OnSetting(setting, accepted);
  return accepted;
}

bool Rig::Operate(PanelAction action) {
  const bool accepted = Try([&] { harness_->panel()->Operate(action); });
  if (checker_) checker_->OnRequest(AskOf(action), accepted);
  return accepted;
}

void Rig::Stop() {
  const bool accepted = Try([&] { harness_->backend().Stop(); });
  if (checker_) checker_->OnRequest(Ask::kStopMove, accepted);
}

void Rig::Write(const RobotCommand& command) {
  harness_->backend().Write(command);
  if (checker_) checker_->OnCommand(command);
}

const RobotState& Rig::Cycle() {
  if (!harness_->AwaitState(state_, backend::ReadRule::kNewest)) {
    throw std::runtime_error("the robot sends no states");
  }
  if (checker_) checker_->OnState(state_);
  return state_;
}

const RobotState& Rig::Answer(RobotCommand command) {
  command.message_id = state_.message_id;
  Write(command);
  return Cycle();
}

bool Rig::StartMotion(const MotionModes& modes) {
  if (!Start(modes)) return false;
  Cycle();
  Cycle();
  return true;
}

bool Rig::ComeToRest(int cycles) {
  for (int i = 0; i < cycles && !IsAtRest(state_); ++i) Cycle();
  return IsAtRest(state_);
}

bool Rig::RecoverToIdle() {
  if (!ComeToRest() || !Recover()) return false;
  for (int i = 0; i < 1000 && state_.robot_mode != RobotMode::kIdle; ++i) Cycle();
  return state_.robot_mode == RobotMode::kIdle;
}

RobotCommand Rig::Same() const {
  RobotCommand command;
  command.q_c = state_.q_d;
  command.dq_c = state_.dq_d;
  command.O_T_EE_c = state_.O_T_EE_c;
  command.O_dP_EE_c = state_.O_dP_EE_c;
  command.elbow_c = state_.elbow_c;
  command.tau_J_d = state_.tau_J_d;
  return command;
}

Finding Rig::finding() const {
  return checker_ ? checker_->finding() : Finding();
}

CheckedRobot ToCheck(const robot::RobotConfig& robot) {
  const onboard::OnboardConfig& config = robot.onboard;
  CheckedRobot checked;
  checked.own_limits = robot.onboard.own_limits;
  checked.limits = {.joints = config.limits,
                    .cartesian = config.cartesian,
                    .start_q_rad = config.start_pose_tolerance_rad,
                    .start_translation_m = config.start_translation_tolerance_m,
                    .start_rotation_rad = config.start_rotation_tolerance_rad,
                    .start_elbow_rad = config.start_elbow_tolerance_rad,
                    .abort_after_lost = config.abort_after_lost,
                    .first_command_timeout_cycles = config.first_command_timeout_cycles};
  const onboard::MeasuredBounds& bounds = config.sensing.measured;
  MeasuredLimits& measured = checked.measured;
  const double share = 1 + bounds.velocity_margin;
  for (std::size_t i = 0; i < kJoints; ++i) {
    measured.q_min[i] = config.limits.q_min[i] - bounds.q_margin_rad;
    measured.q_max[i] = config.limits.q_max[i] + bounds.q_margin_rad;
    measured.dq_max[i] = config.limits.dq_max[i] * share;
    measured.tau_J_max[i] =
        bounds.tau_J_range ? (*bounds.tau_J_range)[i] : 1.2 * config.limits.tau_max[i];
  }
  measured.translation_max = bounds.translation_max_m_per_s;
  measured.rotation_max = config.cartesian.rotation.dp_max * share;
  measured.power_max = bounds.power_max_W;
  measured.clearance = bounds.clearance_m;
  measured.has_hand = bounds.has_hand;
  checked.filters = config.filters;
  checked.collision_behavior = config.collision_behavior;
  checked.is_ideal = robot.plant_kind == robot::PlantKind::kIdeal;
  return checked;
}

}  // namespace twin::test
