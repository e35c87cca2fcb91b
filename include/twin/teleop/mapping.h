#pragma once

#include <cstdint>
#include <optional>

#include "twin/core/joint_vector.h"
#include "twin/core/mobile_base.h"
#include "twin/core/realtime.h"
#include "twin/teleop/operator_sample.h"
#include "twin/teleop/teleoperator_config.h"

namespace twin::teleop {

/// What the robot is doing, for who reads the operator's wishes.
struct Situation {
  bool connected = false;  ///< samples come
  bool arm_rests = true;   ///< its reference, nearly
  bool base_rests = true;
  Transform O_T_EE_d = kIdentityTransform;  ///< the arm's reference
};

/// What the operator wants now.
struct Wish {
  Vector6 twist{};                  ///< of the end effector, base axes; without a pose
  std::optional<Transform> pose{};  ///< of the end effector in the base
  BaseTwist base{};
  bool operator==(const Wish&) const = default;
};

/// What samples mean.
///
/// Axes (arm): deflections of a stick (kRate) are a twist, (|x| - dead zone) / (1 - dead zone) of
/// full speed, in axes of the base or of the end effector; a handle's motion since it was engaged
/// (kPose) is the end effector's since then. Axes (base): x is ahead; turning is y and about z
/// together, both to the left.
///
/// Clutch: whoever is not engaged moves nothing. After that, after a switch of the mode, an
/// emergency stop, and an interruption, a stick must have been in its dead zone before it moves
/// anything, and a handle's motion counts from where it is then. So does it after a switch of frame
/// or scale: nothing ever jumps.
///
/// Mode: at the press, what moves is brought to rest; only then the other is led. Presses are
/// counted: k of them switch k times. Of a stop and a release that come in one sample, the stop
/// counts. Axes that are not finite mean nothing.
///
/// Threads: one. Real-time: noexcept, allocates nothing, O(1).
class Mapping {
 public:
  /// @param arm, base  full speeds: m/s, rad/s.
  struct Speeds {
    double along = 0;
    double about = 0;
    double ahead = 0;
    double turning = 0;
  };
  Mapping(const MappingConfig& config, const Speeds& full) noexcept
      : config_(config), full_(full) {}

  /// @param has_base  false: there is none, and mode presses mean nothing.
  void Begin(bool has_base) noexcept TWIN_REALTIME;

  /// @param sample  the newest; the same again when none has come. @returns the wish.
  [[nodiscard]] Wish Update(const OperatorSample& sample,
                            const Situation& situation) noexcept TWIN_REALTIME;

  [[nodiscard]] Mode mode() const noexcept { return mode_; }
  /// Whether a switch of the mode waits for rest.
  [[nodiscard]] bool is_switching() const noexcept { return mode_ != wanted_; }
  [[nodiscard]] bool stopped() const noexcept { return stopped_; }
  [[nodiscard]] bool fine() const noexcept { return fine_; }
  [[nodiscard]] bool in_tool_frame() const noexcept { return in_tool_frame_; }
  [[nodiscard]] bool ends() const noexcept { return ends_; }
  /// Presses of the gripper's button since Begin().
  [[nodiscard]] std::uint32_t gripper_presses() const noexcept { return gripper_presses_; }

 private:
  void Count(const OperatorSample& sample) noexcept;
  /// Whether the axes count; else they wait for a centred stick, a handle for its anchor.
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
  bool has_counted_ = false;
  OperatorSample last_{};  ///< counters as of the last sample
  Mode mode_ = Mode::kArm;
  Mode wanted_ = Mode::kArm;
  bool stopped_ = false;
  bool fine_ = false;
  bool in_tool_frame_ = false;
  bool ends_ = false;
  std::uint32_t gripper_presses_ = 0;
  bool is_open_ = false;
  Vector6 handle_0_{};                       ///< axes of a handle as it was anchored
  Transform O_T_EE_0_ = kIdentityTransform;  ///< reference then
};

}  // namespace twin::teleop
