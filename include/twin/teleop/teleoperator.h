#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "twin/backend/mobile_base.h"
#include "twin/control/live_reference.h"
#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/model/arm_model.h"
#include "twin/rt/latest_value.h"
#include "twin/teleop/command_peaks.h"
#include "twin/teleop/device.h"
#include "twin/teleop/force_feedback.h"
#include "twin/teleop/led_posture.h"
#include "twin/teleop/mapping.h"
#include "twin/teleop/motion_guard.h"
#include "twin/teleop/shaped_pose.h"
#include "twin/teleop/shaped_velocity.h"
#include "twin/teleop/teleoperator_config.h"
#include "twin/teleop/twist_bounds.h"
#include "twin/teleop/wire.h"

namespace twin::teleop {

/// Status of a teleoperator for observers. Trivially copyable.
struct TeleoperatorStatus {
  Time now{};
  Mode mode = Mode::kArm;
  bool is_switching = false;  ///< waits until all is at rest
  bool stopped = false;
  bool holding = false;
  bool fine = false;
  std::uint8_t joint = 0;  ///< that turns alone, 1 to 7; 0: none
  ActiveBound limit{};     ///< what limits the arm's motion most
  bool finished = false;
  std::uint32_t gripper_presses = 0;
  reference::PoseTarget target{};  ///< x_d
  double arm_error = 0;            ///< m, distance of the measured end effector from x_d
  double most_drive_error = 0;  ///< m, largest arm_error while the base is driven and not stopped
  BaseTwist base_twist{};       ///< commanded
  Vector6 felt{};               ///< wrench at the handle, N and Nm
  Vector6 energy{};             ///< as PassivePort::energy()
  double least_energy = 0;      ///< as PassivePort::least_energy()
  CommandPeaks peaks{};         ///< the base's without emergency stops
  CommandPeaks peaks_at_switch{};  ///< from each mode press to half a second after the switch
  std::uint64_t samples_sent = 0;
  std::uint64_t samples_arrived = 0;
  Duration longest_silence{};  ///< between two samples that arrived
};

/// Lets an operator lead arm and base with a device: a pose controller's live reference, and twist
/// commands to the base.
///
///     device ─ passive port ─ wire ─►  watchdog ─ mapping ─┬─ motion guard ─ shaped pose ─► x_d
///       ▲           ▲                                      └─ shaped twist ─► base
///       └─ felt ────┴──────── wire ◄─  reflected wrench ◄─ state
///
/// A joint that the operator turns alone takes the place of the twist: the guard bounds its speed,
/// and x_d follows the posture (LedPosture).
///
/// Both sides, the operator's (device, port) and the robot's, are here with the wire between them;
/// Next() advances all. In lockstep it runs on the virtual clock, so that a run repeats bit by bit.
///
/// Watchdogs: a lost device, or one that is silent for stale_after, has no control: arm and base
/// come to rest within their bounds and stay. When it returns, the mapping restarts (Mapping).
/// Emergency stop: the base brakes as hard as it can, the arm's reference comes to rest. End: the
/// session is finished once the operator has ended it and everything is at rest.
///
/// Base commands: one twist per update while the base is driven or moves, and none otherwise, so
/// that its own watchdog holds it.
///
/// The hand is not for real time: gripper_presses() counts, and the motion's supervisor acts.
///
/// Threads: Begin() and Next() from the controller's thread; gripper_presses() and finished() from
/// any; TakeStatus() from one other. Real-time: Next() is noexcept, does not allocate, O(pending
/// samples).
class Teleoperator final : public control::LiveReference {
 public:
  /// Connected components; all must outlive the teleoperator.
  struct Parts {
    Device& device;
    backend::MobileBase* base = nullptr;  ///< null without a base
    const model::ArmModel& arm = model::ArmModel::Panda();
    JointLimits limits{};
    bool with_hand = false;                ///< a Franka Hand is on the flange
    Surroundings* surroundings = nullptr;  ///< null: fixed bodies do not limit the motion
    model::LabLimits lab{};                ///< limits of the lab
  };

  /// @param seed  of delay and loss. @throws InputError as the configurations' Validate().
  Teleoperator(const Parts& parts, const TeleoperatorConfig& config, const WireConfig& wire,
               std::uint64_t seed);

  void Begin(const Transform& O_T_EE, Time now) override;
  [[nodiscard]] reference::PoseTarget Next(const RobotState& state,
                                           Time now) noexcept TWIN_REALTIME override;
  [[nodiscard]] std::optional<reference::JointTarget> posture() const noexcept
      TWIN_REALTIME override {
    return posture_.now();
  }
  [[nodiscard]] bool finished() const noexcept TWIN_REALTIME override {
    return finished_.load(std::memory_order_relaxed);  // relaxed: publishes no other data
  }

  [[nodiscard]] std::uint32_t gripper_presses() const noexcept {
    return gripper_presses_.load(std::memory_order_relaxed);  // relaxed: publishes no other data
  }

  /// The newest status, about a millisecond old. For one consumer.
  [[nodiscard]] const TeleoperatorStatus& TakeStatus() noexcept {
    status_shown_.Refresh();
    return status_shown_.value();
  }

 private:
  /// Reads and sends the device's sample; applies the received feedback. @param T  s.
  void TendOperator(Time now, double T) noexcept;
  /// Takes arrived samples. @returns true if an operator leads.
  bool Receive(Time now) noexcept;
  void LeadArm(const Wish& wish, const RobotState& state, double T) noexcept;
  void TurnJoint(const Wish& wish, const RobotState& state, double T) noexcept;
  void LeadBase(const Wish& wish, double T) noexcept;
  void Answer(const RobotState& state, Time now, double T) noexcept;
  void Show(const RobotState& state, Time now) noexcept;
  [[nodiscard]] bool base_rests() const noexcept;
  [[nodiscard]] BasePose Odometry() const noexcept {
    return base_ == nullptr ? BasePose{} : base_->ReadState().odometry;
  }
  /// Displacement of the handle, m and rad.
  [[nodiscard]] Vector6 HandleOf(const OperatorSample& sample) const noexcept;

  Device& device_;
  backend::MobileBase* base_;
  TeleoperatorConfig config_;

  // The operator's side.
  PassivePort port_;
  OperatorSample handle_{};  ///< the device's last sample
  OperatorFeedback came_{};  ///< the newest received feedback
  std::optional<Time> last_answer_;
  OperatorFeedback felt_{};
  Wire<OperatorSample> to_robot_;
  Wire<OperatorFeedback> from_robot_;

  // The robot's side.
  OperatorSample sample_{};  ///< the newest that arrived
  std::optional<Time> last_arrival_;
  Mapping mapping_;
  LedPosture posture_;
  bool has_posture_ = false;  ///< since Begin()
  MotionGuard guard_;
  TwistBounds bounds_;
  ShapedPose pose_;
  ShapedVelocity<1> turned_;  ///< speed of the joint that turns alone
  ShapedVelocity<1> ahead_;
  ShapedVelocity<1> turning_;
  ReflectedWrench reflected_;
  bool is_stopped_ = false;  ///< the base has received an emergency stop
  bool is_braking_ = false;  ///< from an emergency stop until the base is released and at rest
  ActiveBound limit_{};      ///< removed most of the last command
  std::uint64_t answers_ = 0;
  bool connected_ = false;

  Time last_{};
  std::optional<Time> switched_;  ///< last time at which a switch waited
  PeakWatch watch_;
  TeleoperatorStatus status_{};
  rt::LatestValue<TeleoperatorStatus> status_shown_;
  std::atomic<std::uint32_t> gripper_presses_{0};
  std::atomic<bool> finished_{false};
};

}  // namespace twin::teleop
