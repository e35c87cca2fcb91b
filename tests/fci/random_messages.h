#pragma once

#include <array>
#include <cstdint>

#include "twin/core/hand_command.h"
#include "twin/core/random.h"
#include "twin/core/robot_state.h"

namespace twin::fci {

/// Fills values at random from a seed, each differently.
class RandomMessages {
 public:
  explicit RandomMessages(std::uint64_t seed) : random_(seed, RandomStream::kTest) {}

  template <typename... T>
  void Fill(T&... values) {
    (FillOne(values), ...);
  }

  [[nodiscard]] std::uint32_t Below(std::uint32_t count) { return Bits() % count; }

  [[nodiscard]] RobotState State() {
    RobotState s;
    Fill(s.message_id, s.O_T_EE, s.O_T_EE_d, s.F_T_EE, s.EE_T_K, s.F_T_NE, s.NE_T_EE, s.m_ee,
         s.I_ee, s.F_x_Cee, s.m_load, s.I_load, s.F_x_Cload, s.elbow, s.elbow_d, s.tau_J, s.tau_J_d,
         s.dtau_J, s.q, s.q_d, s.dq, s.dq_d, s.ddq_d, s.joint_contact, s.cartesian_contact,
         s.joint_collision, s.cartesian_collision, s.tau_ext_hat_filtered, s.O_F_ext_hat_K,
         s.K_F_ext_hat_K, s.O_dP_EE_d, s.O_ddP_O, s.elbow_c, s.delbow_c, s.ddelbow_c, s.O_T_EE_c,
         s.O_dP_EE_c, s.O_ddP_EE_c, s.theta, s.dtheta, s.errors, s.reflex_reason,
         s.control_command_success_rate);
    s.motion_generator_mode = static_cast<MotionGeneratorMode>(Below(5));
    s.controller_mode = static_cast<ControllerMode>(Below(4));
    s.robot_mode = static_cast<RobotMode>(Below(7));
    return s;
  }

  [[nodiscard]] RobotCommand Command() {
    RobotCommand c;
    Fill(c.message_id, c.q_c, c.dq_c, c.O_T_EE_c, c.O_dP_EE_c, c.elbow_c, c.valid_elbow,
         c.motion_generation_finished, c.tau_J_d);
    return c;
  }

  [[nodiscard]] HandState Hand() {
    HandState s;
    Fill(s.message_id, s.width, s.max_width, s.is_grasped, s.temperature);
    return s;
  }

  [[nodiscard]] VacuumState Vacuum() {
    VacuumState s;
    Fill(s.message_id, s.in_control_range, s.part_detached, s.part_present, s.actual_power,
         s.vacuum);
    s.device_status = static_cast<PumpStatus>(Below(4));
    return s;
  }

 private:
  std::uint32_t Bits() { return random_.Bits(next_++)[0]; }

  void FillOne(double& value) { value = 100 * random_.Normal(next_++); }
  void FillOne(bool& value) { value = Bits() % 2 == 1; }
  void FillOne(std::uint8_t& value) { value = static_cast<std::uint8_t>(Bits()); }
  void FillOne(std::uint16_t& value) { value = static_cast<std::uint16_t>(Bits()); }
  void FillOne(std::uint32_t& value) { value = Bits(); }
  void FillOne(std::int32_t& value) { value = static_cast<std::int32_t>(Bits()); }
  void FillOne(std::int64_t& value) {
    value = static_cast<std::int64_t>(std::uint64_t{Bits()} << 32 | Bits());
  }
  void FillOne(std::uint64_t& value) { value = std::uint64_t{Bits()} << 32 | Bits(); }
  void FillOne(RobotErrors& errors) {
    for (std::size_t i = 0; i < kRobotErrorCount; ++i) errors.set(i, Bits() % 2 == 1);
  }
  template <typename T, std::size_t N>
  void FillOne(std::array<T, N>& values) {
    for (T& value : values) FillOne(value);
  }

  Random random_;
  std::uint64_t next_ = 0;
};

}  // namespace twin::fci
