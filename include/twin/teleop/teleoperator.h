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
#include "twin/teleop/mapping.h"
#include "twin/teleop/posture_guard.h"
#include "twin/teleop/shaped_pose.h"
#include "twin/teleop/shaped_velocity.h"
#include "twin/teleop/teleoperator_config.h"
#include "twin/teleop/wire.h"

namespace twin::teleop {

/// What a teleoperator does, for those who look on. Trivially copyable.
struct TeleoperatorStatus {
  Time now{};
  Mode mode = Mode::kArm;
  bool is_switching = false;  ///< waits for rest
  bool stopped = false;
  bool holding = false;
  bool fine = false;
  bool at_border = false;
  bool finished = false;
  std::uint32_t gripper_presses = 0;
  reference::PoseTarget target{};  ///< x_d
  double arm_error = 0;            ///< m, of the measured end effector from x_d
  double most_drive_error = 0;     ///< m, the largest arm_error while the base was led, not stopped
  BaseTwist base_twist{};          ///< commanded
  Vector6 felt{};                  ///< wrench at the handle, N and Nm
  Vector6 energy{};                ///< as PassivePort::energy()
  double least_energy = 0;         ///< as PassivePort::least_energy()
  CommandPeaks peaks{};            ///< the base's: but of emergency stops
  CommandPeaks peaks_at_switch{};  ///< from each mode press to half a second after the switch
  std::uint64_t samples_sent = 0;
  std::uint64_t samples_arrived = 0;
  Duration longest_silence{};  ///< between two samples that arrived
};

/// Lets a person lead the arm and the base by a device: the reference of a controller of poses, and
/// commands to the base.
///
///     device ─ passive port ─ wire ─►  watchdog ─ mapping ─┬─ posture guard ─ shaped pose ─► x_d
///       ▲           ▲                                      └─ shaped twist ─► base
///       └─ felt ────┴──────── wire ◄─  reflected wrench ◄─ state
///
/// The operator's end (device, port) and the robot's are both here, with the wire between them; all
/// advance with Next(). In lockstep that is the virtual clock, so that a run repeats bit by bit.
///
/// Watchdogs: a device that is lost, or of which nothing has come for stale_after, leads nothing:
/// arm and base are brought to rest within their bounds, and stay. When it is back it begins anew
/// (Mapping). Emergency stop: the base brakes as hard as it can, the arm's reference comes to rest.
/// The end: the session is finished when the operator has ended it and all is at rest.
///
/// Commands to the base: a twist per update while the base is led or moves; none otherwise, so that
/// its own watchdog has it stand.
///
/// The hand is not for real time: gripper_presses() counts, and who attends the motion acts.
///
/// Threads: Begin() and Next() from the controller's thread; gripper_presses() and finished() from
/// any; TakeStatus() from one other. Real-time: Next() is noexcept, allocates nothing, O(samples on
/// the way).
class Teleoperator final : public control::LiveReference {
 public:
  /// What it works with; all must outlive it.
  struct Parts {
    Device& device;
    backend::MobileBase* base = nullptr;  ///< null: there is none
    const model::ArmModel& arm = model::ArmModel::Panda();
    JointLimits limits{};
  };

  /// @param seed  of delay and loss. @throws InputError as the configurations' Validate().
  Teleoperator(const Parts& parts, const TeleoperatorConfig& config, const WireConfig& wire,
               std::uint64_t seed);

  void Begin(const Transform& O_T_EE, Time now) override;
  [[nodiscard]] reference::PoseTarget Next(const RobotState& state,
                                           Time now) noexcept TWIN_REALTIME override;
  [[nodiscard]] bool finished() const noexcept TWIN_REALTIME override {
    return finished_.load(std::memory_order_relaxed);  // alone; orders nothing
  }

  [[nodiscard]] std::uint32_t gripper_presses() const noexcept {
    return gripper_presses_.load(std::memory_order_relaxed);  // alone; orders nothing
  }

  /// The newest status, as of a millisecond or so ago. Its one consumer.
  [[nodiscard]] const TeleoperatorStatus& TakeStatus() noexcept {
    status_shown_.Refresh();
    return status_shown_.value();
  }

 private:
  /// Reads the device and sends; makes felt what has come back. @param T  s.
  void TendOperator(Time now, double T) noexcept;
  /// Takes what has arrived. @returns whether somebody leads.
  bool Receive(Time now) noexcept;
  void LeadArm(const Wish& wish, const RobotState& state, double T) noexcept;
  void LeadBase(const Wish& wish, double T) noexcept;
  void Answer(const RobotState& state, Time now, double T) noexcept;
  void Show(const RobotState& state, Time now) noexcept;
  [[nodiscard]] bool base_rests() const noexcept;
  /// Where the handle is, as a way in m and rad.
  [[nodiscard]] Vector6 HandleOf(const OperatorSample& sample) const noexcept;

  Device& device_;
  backend::MobileBase* base_;
  TeleoperatorConfig config_;

  // The operator's end.
  PassivePort port_;
  OperatorSample handle_{};  ///< the last that the device gave
  OperatorFeedback came_{};  ///< the newest that came back
  std::optional<Time> last_answer_;
  OperatorFeedback felt_{};
  Wire<OperatorSample> to_robot_;
  Wire<OperatorFeedback> from_robot_;

  // The robot's end.
  OperatorSample sample_{};  ///< the newest that arrived
  std::optional<Time> last_arrival_;
  Mapping mapping_;
  PostureGuard guard_;
  ShapedPose pose_;
  ShapedVelocity<1> ahead_;
  ShapedVelocity<1> turning_;
  ReflectedWrench reflected_;
  bool is_stopped_ = false;  ///< the base has been told to stop
  bool is_braking_ = false;  ///< it has, until it is released and rests
  bool guarded_ = false;     ///< the posture took most of the last wish away
  std::uint64_t answers_ = 0;
  bool connected_ = false;

  Time last_{};
  std::optional<Time> switched_;  ///< the last moment at which a switch waited
  PeakWatch watch_;
  TeleoperatorStatus status_{};
  rt::LatestValue<TeleoperatorStatus> status_shown_;
  std::atomic<std::uint32_t> gripper_presses_{0};
  std::atomic<bool> finished_{false};
};

}  // namespace twin::teleop
