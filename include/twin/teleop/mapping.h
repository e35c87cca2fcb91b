#pragma once

#include <cstdint>
#include <optional>

#include "twin/core/joint_vector.h"
#include "twin/core/mobile_base.h"
#include "twin/core/realtime.h"
#include "twin/teleop/operator_sample.h"
#include "twin/teleop/teleoperator_config.h"

namespace twin::teleop {

/// State of the robot that the mapping needs.
struct Situation {
  bool connected = false;  ///< samples arrive
  bool arm_rests = true;   ///< its reference is nearly at rest
  bool base_rests = true;
  Transform O_T_EE_d = kIdentityTransform;  ///< the arm's reference
};

/// The operator's current command.
struct Wish {
  Vector6 twist{};                  ///< of the end effector, base axes; if no pose is given
  std::optional<Transform> pose{};  ///< of the end effector in the base
  BaseTwist base{};
  std::uint8_t joint = 0;  ///< 1 to 7: this joint turns alone, and nothing else is wished
  double turn = 0;         ///< of that joint, rad/s
  bool operator==(const Wish&) const = default;
};

/// Maps samples to motion commands.
///
/// Axes (arm): deflections of a stick (kRate) are a twist, (|x| - dead zone) / (1 - dead zone) of
/// full speed, in axes of the base or the end effector. For a handle (kPose), the end effector's
/// displacement is the handle's since it was engaged. Axes (base): x is forward; y and rotation
/// about z both turn left.
///
/// Clutch: a disengaged device moves nothing. After disengagement, a mode switch, an emergency stop
/// or an interruption, a stick must return to its dead zone before it has effect, and a handle's
/// displacement counts from its current position. The latter also holds after a switch of frame or
/// scale, so that the command never jumps.
///
/// Joints: a sample with a joint turns it by axes[0]; before another joint, or the hand, moves, the
/// arm comes to rest. Between hand and joints a stick must return to its dead zone.
///
/// Mode: a press first brings the moving part to rest, then selects the other. Presses are counted:
/// k presses switch k times. If a stop and a release arrive in one sample, the stop counts. Axes
/// that are not finite are ignored.
///
/// Threads: one. Real-time: noexcept, does not allocate, O(1).
class Mapping {
 public:
  /// @param arm, base  full speeds: m/s, rad/s.
  struct Speeds {
    double along = 0;
    double about = 0;
    double ahead = 0;
    double turning = 0;
    double joint = 0;
  };
  Mapping(const MappingConfig& config, const Speeds& full) noexcept
      : config_(config), full_(full) {}

  /// Counters of presses begin at zero. @param has_base  false: mode presses have no effect.
  void Begin(bool has_base) noexcept TWIN_REALTIME;

  /// @param sample  the newest; repeated if none has arrived. @returns the operator's command.
  [[nodiscard]] Wish Update(const OperatorSample& sample,
                            const Situation& situation) noexcept TWIN_REALTIME;

  [[nodiscard]] Mode mode() const noexcept { return mode_; }
  /// The joint that turns alone, 1 to 7; 0: none.
  [[nodiscard]] std::uint8_t joint() const noexcept { return joint_; }
  /// True while a switch of the mode or of the joint waits for rest.
  [[nodiscard]] bool is_switching() const noexcept {
    return mode_ != wanted_ || joint_ != JointOf(last_);
  }
  /// True while deflected sticks lead nothing because they have not been centred since the operator
  /// could not lead: from before Begin(), a lapse of the connection, a stop or a switch.
  [[nodiscard]] bool awaits_release() const noexcept { return awaits_release_; }
  [[nodiscard]] bool stopped() const noexcept { return stopped_; }
  [[nodiscard]] bool fine() const noexcept { return fine_; }
  [[nodiscard]] bool in_tool_frame() const noexcept { return in_tool_frame_; }
  [[nodiscard]] bool ends() const noexcept { return ends_; }
  /// Presses of the gripper button since Begin().
  [[nodiscard]] std::uint32_t gripper_presses() const noexcept { return gripper_presses_; }

 private:
  [[nodiscard]] static std::uint8_t JointOf(const OperatorSample& sample) noexcept {
    const bool is_joint = sample.kind == AxisKind::kRate && sample.joint <= kJoints;
    return is_joint ? sample.joint : std::uint8_t{0};
  }
  void Count(const OperatorSample& sample) noexcept;
  /// True if the axes count; otherwise waits for a centred stick, or anchors a handle.
  bool Open(const OperatorSample& sample, const Situation& situation) noexcept;
  [[nodiscard]] double Deflection(double x) const noexcept;
  [[nodiscard]] Vector6 ArmTwist(const OperatorSample& sample,
                                 const Transform& O_T_EE_d) const noexcept;
  [[nodiscard]] Transform ArmPose(const OperatorSample& sample) const noexcept;
  [[nodiscard]] BaseTwist Drive(const OperatorSample& sample) const noexcept;
  [[nodiscard]] double scale() const noexcept { return fine_ ? config_.fine : 1; }

  MappingConfig config_;
  Speeds full_;
  bool has_base_ = false;
  OperatorSample last_{};  ///< counters of the last sample
  Mode mode_ = Mode::kArm;
  Mode wanted_ = Mode::kArm;
  std::uint8_t joint_ = 0;
  bool stopped_ = false;
  bool fine_ = false;
  bool in_tool_frame_ = false;
  bool ends_ = false;
  std::uint32_t gripper_presses_ = 0;
  bool is_open_ = false;
  bool awaits_release_ = false;
  Vector6 handle_0_{};                       ///< axes of a handle when it was anchored
  Transform O_T_EE_0_ = kIdentityTransform;  ///< reference at that time
};

}  // namespace twin::teleop
