#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "twin/core/random.h"
#include "twin/record/cycle_record.h"
#include "twin/record/log_records.h"
#include "twin/record/scene_record.h"

namespace twin::record {

/// Numbers for records: uniform in [-1, 1), all different, a pure function of (seed, cycle, draw).
class SampleNumbers {
 public:
  SampleNumbers(std::uint64_t seed, std::uint64_t cycle)
      : random_(seed, RandomStream::kTest), cycle_(cycle) {}

  double operator()() { return 2 * random_.Uniform(cycle_, draw_++) - 1; }
  template <std::size_t kSize>
  void operator()(std::array<double, kSize>& values) {
    for (double& value : values) value = (*this)();
  }

 private:
  Random random_;
  std::uint64_t cycle_;
  std::uint32_t draw_ = 0;
};

/// About a run that never was.
inline RunInfo SampleRun() {
  return {.scenario = "sample",
          .seed = 18446744073709551615ULL,
          .version = "0.1.0",
          .drive = "lockstep",
          .scenario_yaml = "name: sample\n# \xc3\xbc\n"};
}

/// Messages of topic /tf for `cycles` sample cycles from the first on.
inline std::uint64_t SampleFrames(std::uint64_t cycles) {
  return (cycles + 19) / 20;
}

/// A cycle in which every number of the robot state differs from every other: the worst case for
/// compression. The configuration changes every 500 cycles; cycle 3 holds, cycle 5 is violated, in
/// cycle 7 there are a mobile base and accelerometers.
inline record::CycleRecord SampleCycle(std::uint64_t k) {
  record::CycleRecord record;
  RobotState& s = record.state;
  SampleNumbers numbers(1, k);
  SampleNumbers config(2, k / 500);
  record.at = Time(static_cast<std::int64_t>(k) * kCycle);
  s.message_id = k + 1000;
  for (auto* pose : {&s.O_T_EE, &s.O_T_EE_d, &s.O_T_EE_c}) numbers(*pose);
  for (auto* pose : {&s.F_T_EE, &s.EE_T_K, &s.F_T_NE, &s.NE_T_EE}) config(*pose);
  s.m_ee = config();
  s.m_load = config();
  config(s.I_ee);
  config(s.I_load);
  config(s.F_x_Cee);
  config(s.F_x_Cload);
  config(s.O_ddP_O);
  for (auto* elbow : {&s.elbow, &s.elbow_d, &s.elbow_c, &s.delbow_c, &s.ddelbow_c}) numbers(*elbow);
  for (auto* joints :
       {&s.tau_J, &s.tau_J_d, &s.dtau_J, &s.q, &s.q_d, &s.dq, &s.dq_d, &s.ddq_d, &s.joint_contact,
        &s.joint_collision, &s.tau_ext_hat_filtered, &s.theta, &s.dtheta, &record.dddq_d}) {
    numbers(*joints);
  }
  for (auto* wrench : {&s.cartesian_contact, &s.cartesian_collision, &s.O_F_ext_hat_K,
                       &s.K_F_ext_hat_K, &s.O_dP_EE_d, &s.O_dP_EE_c, &s.O_ddP_EE_c}) {
    numbers(*wrench);
  }
  s.motion_generator_mode = MotionGeneratorMode::kJointPosition;
  s.controller_mode = ControllerMode::kJointImpedance;
  s.robot_mode = RobotMode::kMove;
  s.control_command_success_rate = 0.99;
  record.fate = k == 3 ? record::CommandFate::kHeld : record::CommandFate::kServed;
  record.lost_in_row = k == 3 ? 1 : 0;
  record.dropped = k == 3 ? 2 : 0;
  if (k == 5) {
    s.errors.set(0).set(40);
    s.reflex_reason.set(25);
    record.violated = true;
    record.violation = {.error = RobotError::kJointVelocityViolation,
                        .axis = 6,
                        .value = 2.7,
                        .limit = 2.61,
                        .message_id = 1005};
  }
  if (k == 7) {
    BaseState& base = record.base.emplace();
    base.message_id = 77;
    base.odometry = {numbers(), numbers(), numbers()};
    base.twist = {numbers(), numbers()};
    base.twist_d = {numbers(), numbers()};
    numbers(base.dq_wheels);
    base.mode = BaseMode::kEmergencyStop;
    numbers(s.accelerometer_top);
    numbers(s.accelerometer_bottom);
  }
  return record;
}

/// The tick that answers SampleCycle(k).
inline record::TickRecord SampleTick(std::uint64_t k) {
  record::TickRecord record;
  SampleNumbers numbers(3, k);
  record.message_id = k + 1000;
  record.read = Time(static_cast<std::int64_t>(k) * kCycle + std::chrono::microseconds(200));
  record.written = record.read + Duration(20'000 + static_cast<std::int64_t>(k % 7));
  record.action = k == 3   ? record::TickAction::kSkipped
                  : k == 4 ? record::TickAction::kInvalid
                           : record::TickAction::kWritten;
  record.skipped_states = k == 3 ? 1 : 0;
  record.deposit_time = record.read - std::chrono::milliseconds(10);
  numbers(record.q_ext);
  numbers(record.dq_ext);
  record.stalled = k % 3 == 0;
  if (k == 3 || k == 4) return record;
  if (k % 2 == 0) {
    record.margin = numbers();
    record.kept_back = static_cast<std::uint8_t>(k % 128);
  }
  RobotCommand& command = record.command;
  command.message_id = record.message_id;
  numbers(command.q_c);
  numbers(command.dq_c);
  numbers(command.O_T_EE_c);
  numbers(command.O_dP_EE_c);
  numbers(command.elbow_c);
  numbers(command.tau_J_d);
  command.valid_elbow = k % 2 == 0;
  command.motion_generation_finished = k % 3 == 0;
  return record;
}

/// The scene of a frame at SampleCycle(k): an arm with its fingers and an object, k % 4 contacts
/// and k % 2 pushes.
inline record::SceneRecord SampleScene(std::uint64_t k) {
  record::SceneRecord scene;
  SampleNumbers numbers(4, k);
  scene.at = Time(static_cast<std::int64_t>(k) * kCycle);
  scene.positions = 16;
  for (std::size_t i = 0; i < scene.positions; ++i) scene.qpos[i] = numbers();
  scene.contacts = static_cast<std::uint32_t>(k % 4);
  scene.pushes = static_cast<std::uint32_t>(k % 2);
  for (std::size_t i = 0; i < scene.contacts; ++i) {
    numbers(scene.contact[i].p_W);
    numbers(scene.contact[i].force_W);
  }
  for (std::size_t i = 0; i < scene.pushes; ++i) {
    numbers(scene.push[i].p_W);
    numbers(scene.push[i].force_W);
  }
  return scene;
}

/// A plan that carries an object.
inline PlanRecord SamplePlan() {
  PlanRecord plan{.id = "place",
                  .caption = "Onto the shelf",
                  .from = Time(std::chrono::milliseconds(20)),
                  .until = Time(std::chrono::milliseconds(900)),
                  .q = JointVector{0, 0.5, 0, -1.5, 0, 2, 0.25},
                  .path = {{0.5, 0, 0.25}, {0.5, 0.125, 0.5}},
                  .object = "block",
                  .O_T_object = kIdentityTransform};
  plan.O_T_object[14] = 0.75;
  return plan;
}

}  // namespace twin::record
