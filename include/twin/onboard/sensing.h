#pragma once

#include <cstdint>

#include "twin/core/body_interface.h"
#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/core/setting.h"
#include "twin/model/arm_model.h"
#include "twin/model/self_collision.h"
#include "twin/onboard/contact_monitor.h"
#include "twin/onboard/external_torque_observer.h"
#include "twin/onboard/external_wrench.h"
#include "twin/onboard/measured_arm.h"
#include "twin/onboard/measured_monitor.h"
#include "twin/onboard/violations.h"

namespace twin::onboard {

/// Parameters of INT's measured side. Values that are not public are decisions, each with its
/// reason.
struct SensingConfig {
  JointLimits joints;
  CartesianLimits cartesian;
  model::ArmModel arm = model::ArmModel::Panda();

  /// Gain of the external torque observer, 1/s, in (0, 1000]. Its inverse, 10 ms, is the time
  /// constant of a push: fast enough for a collision, slow enough that the noise of dq, amplified
  /// by gain and inertia, stays far below the smallest threshold in use.
  double observer_gain = 100;
  /// Gain of the external wrench above which the arm counts as singular and the wrench is zero, > 0
  /// (EstimateWrench). With 20, an error of 1 Nm, what friction leaves, stays below the lowest
  /// threshold with which a robot starts, 20 N.
  double wrench_gain_max = 20;
  MeasuredBounds measured;

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

/// INT's measured side: external torque, contacts and collisions, and checks of sensor values
/// independent of commands.
///
/// Threads: INT's. Real-time: all but the constructor; noexcept, allocates nothing.
class Sensing {
 public:
  /// @pre config is valid (SensingConfig::Validate).
  explicit Sensing(const SensingConfig& config) noexcept;

  void SetCollisionBehavior(const setting::CollisionBehavior& behavior) noexcept;

  /// Restarts the observer at zero, after a jump of the arm's position, a change of the payload, or
  /// a time under closed brakes. Collisions stay latched.
  void Reset(const JointSensors& sensors, const ArmSetup& setup) noexcept TWIN_REALTIME;

  /// Applies a changed setup to arm(), at the last measured position.
  void Measure(const ArmSetup& setup) noexcept { Measure(measured_.sensors, setup); }

  /// Processes new sensor values, once per cycle.
  /// @param accelerates  whether the reference does; selects the thresholds.
  void Update(const JointSensors& sensors, const ArmSetup& setup,
              bool accelerates) noexcept TWIN_REALTIME;

  /// Collisions found by the last Update(), above an upper threshold: joint_reflex,
  /// cartesian_reflex, with the torque or force as value and the threshold as limit.
  [[nodiscard]] Violations Collisions(std::uint64_t message_id) const noexcept TWIN_REALTIME;

  /// Measured limits exceeded in the last Update(): joint position, joint velocity, Cartesian
  /// velocity, self-collision, power, tau_J range (MeasuredMonitor).
  /// @param tau_J_d  applied, without gravity, Nm.
  /// @param is_cartesian  a Cartesian motion generator runs.
  [[nodiscard]] Violations CheckMeasured(const JointVector& tau_J_d, std::uint64_t message_id,
                                         bool is_cartesian = false) const noexcept TWIN_REALTIME;

  /// Unlatches the collisions, for a recovery.
  void ClearCollisions() noexcept;

  /// Whether only people can free the arm: a joint is beyond its measured limit.
  [[nodiscard]] bool NeedsManualRecovery() const noexcept;

  /// Shared model quantities of the last Update().
  [[nodiscard]] const MeasuredArm& arm() const noexcept { return arm_; }

  [[nodiscard]] const JointVector& tau_ext_hat_filtered() const noexcept;
  [[nodiscard]] const Vector6& O_F_ext_hat_K() const noexcept;  ///< zero near singularities
  [[nodiscard]] const Vector6& K_F_ext_hat_K() const noexcept;
  /// Levels as in the robot state: 1 above the threshold, else 0.
  [[nodiscard]] const JointVector& joint_contact() const noexcept;
  [[nodiscard]] const Vector6& cartesian_contact() const noexcept;
  [[nodiscard]] const JointVector& joint_collision() const noexcept;  ///< latched
  [[nodiscard]] const Vector6& cartesian_collision() const noexcept;  ///< latched

 private:
  void Measure(const JointSensors& sensors, const ArmSetup& setup) noexcept;

  double wrench_gain_max_;
  model::ArmModel model_;
  ExternalTorqueObserver observer_;
  ExternalWrench wrench_;
  ContactMonitor contacts_;
  MeasuredMonitor monitor_;
  model::SelfDistanceWatch self_distance_;
  MeasuredArm arm_;
  MeasuredMonitor::Measured measured_;
};

}  // namespace twin::onboard
