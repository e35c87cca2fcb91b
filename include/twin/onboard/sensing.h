#pragma once

#include <cstdint>

#include "twin/core/joint_interface.h"
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

/// What INT finds in what it measures, and how far that may go. Figures that are not public are
/// decisions; each says why it is what it is.
struct SensingConfig {
  JointLimits joints;
  CartesianLimits cartesian;

  /// Gain of the external torque observer, 1/s, in (0, 1000]: a push shows with a time constant of
  /// its inverse, 10 ms, soon enough for a collision and slow enough that the noise of dq, enlarged
  /// by this gain and the inertia, stays far below the least threshold in use.
  double observer_gain = 100;
  /// Gain of the external wrench above which the arm counts as singular and the wrench is zero, > 0
  /// (EstimateWrench).
  double wrench_gain_max = 30;
  MeasuredBounds measured;

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

/// INT's measured side: external torque, contacts and collisions, and the checks of what the
/// sensors show, whatever was commanded.
///
/// Threads: INT's. Real-time: all but the constructor; noexcept, allocates nothing.
class Sensing {
 public:
  /// @pre config is valid (SensingConfig::Validate).
  explicit Sensing(const SensingConfig& config) noexcept;

  void SetCollisionBehavior(const setting::CollisionBehavior& behavior) noexcept;

  /// The arm is somewhere else, or the payload is another, or what held it was not the torque (the
  /// brakes): the observer starts anew, at zero. Collisions stay latched.
  void Reset(const JointSensors& sensors, const ArmSetup& setup) noexcept TWIN_REALTIME;

  /// A setter changed the setup: arm() is of it from now on, where the sensors last showed the arm.
  void Measure(const ArmSetup& setup) noexcept { Measure(measured_.sensors, setup); }

  /// New sensor values, once a cycle.
  /// @param accelerates  the reference does: which thresholds count.
  void Update(const JointSensors& sensors, const ArmSetup& setup,
              bool accelerates) noexcept TWIN_REALTIME;

  /// What the last Update() found above an upper threshold: joint_reflex, cartesian_reflex, with
  /// the torque or force as value and the threshold as limit.
  [[nodiscard]] Violations Collisions(std::uint64_t message_id) const noexcept TWIN_REALTIME;

  /// What the last Update() found beyond the measured limits: joint position, joint velocity,
  /// Cartesian velocity, self-collision, power, tau_J range (MeasuredMonitor).
  /// @param tau_J_d  that acts, without gravity, Nm.
  /// @param is_cartesian  the motion is one of a Cartesian motion generator.
  [[nodiscard]] Violations CheckMeasured(const JointVector& tau_J_d, std::uint64_t message_id,
                                         bool is_cartesian = false) const noexcept TWIN_REALTIME;

  /// Unlatches the collisions: recovery.
  void ClearCollisions() noexcept;

  /// Whether the arm still is where only people can get it out: a joint beyond its measured limit.
  [[nodiscard]] bool NeedsManualRecovery() const noexcept;

  /// Of the last Update(): who needs it as well need not compute it again.
  [[nodiscard]] const MeasuredArm& arm() const noexcept { return arm_; }

  [[nodiscard]] const JointVector& tau_ext_hat_filtered() const noexcept;
  [[nodiscard]] const Vector6& O_F_ext_hat_K() const noexcept;  ///< zero near singularities
  [[nodiscard]] const Vector6& K_F_ext_hat_K() const noexcept;
  /// Levels as the state reports them: 1 above the threshold, else 0.
  [[nodiscard]] const JointVector& joint_contact() const noexcept;
  [[nodiscard]] const Vector6& cartesian_contact() const noexcept;
  [[nodiscard]] const JointVector& joint_collision() const noexcept;  ///< latched
  [[nodiscard]] const Vector6& cartesian_collision() const noexcept;  ///< latched

 private:
  void Measure(const JointSensors& sensors, const ArmSetup& setup) noexcept;

  double wrench_gain_max_;
  ExternalTorqueObserver observer_;
  ExternalWrench wrench_;
  ContactMonitor contacts_;
  MeasuredMonitor monitor_;
  model::SelfDistanceWatch self_distance_;
  MeasuredArm arm_;
  MeasuredMonitor::Measured measured_;
};

}  // namespace twin::onboard
