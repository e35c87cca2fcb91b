#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "twin/core/error.h"
#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/model/arm_model.h"

namespace twin::model {

/// What a region limits.
enum class LimitedPart : std::uint8_t {
  kEndEffector,  ///< the origin of the end effector's frame, O_T_EE
  kElbow,        ///< the origin of joint 4's frame
  kHand,         ///< the Franka Hand, fingers open: kHandSpheres
};
inline constexpr std::size_t kLimitedParts = 3;
/// "end effector".
[[nodiscard]] std::string_view Name(LimitedPart part) noexcept;

/// A sphere in the flange's frame.
struct FlangeSphere {
  Vector3 centre{};   ///< m
  double radius = 0;  ///< m
};

/// Covers the hand's body (the first four) and its fingers at any opening (the others), to 0.122 m
/// in front of the flange and 0.12 m to either side. Source: fitted to models/robots/hand; a test
/// compares them.
[[nodiscard]] std::span<const FlangeSphere> HandSpheres() noexcept;
/// Stands for the hand where none is mounted.
inline constexpr FlangeSphere kBareFlange{{0, 0, 0}, 0.05};

/// Points with low <= p <= high in each axis of the base, m.
struct LimitBox {
  Vector3 low{};
  Vector3 high{};
  bool operator==(const LimitBox&) const = default;
};

/// Points with n . p <= offset, n the unit vector along `normal`, which points out of the region.
struct HalfSpace {
  Vector3 normal{};   ///< base axes, any length above 0
  double offset = 0;  ///< m, from the base's origin
  bool operator==(const HalfSpace&) const = default;
};

/// A region of space, in the base's frame (O), in which parts of the robot must stay, or out of
/// which. With a mobile base the region moves with it.
struct LimitRegion {
  static constexpr std::size_t kLongestName = 31;  ///< bytes

  std::string name;  ///< for messages
  std::vector<LimitedPart> parts{LimitedPart::kEndEffector, LimitedPart::kElbow,
                                 LimitedPart::kHand};
  bool keep_inside = true;
  std::variant<LimitBox, HalfSpace> shape;
  bool operator==(const LimitRegion&) const = default;
};

/// A motion breaks a limit of the lab. The text says which, the value, the bound, the time and the
/// joint positions.
class LimitBreach : public InputError {
  using InputError::InputError;
};

/// Limits that a lab demands beside the robot's own.
struct LabLimits {
  static constexpr std::size_t kMostRegions = 16;

  std::vector<LimitRegion> regions{};
  std::optional<JointVector> dq_max{};   ///< speed of each joint, rad/s
  std::optional<double> v_max{};         ///< speed of the end effector's origin, m/s
  std::optional<double> w_max{};         ///< rate of turn of the end effector, rad/s
  std::optional<double> force_max{};     ///< norm of the external force at the end effector, N
  std::optional<JointVector> tau_max{};  ///< external torque of each joint, magnitude, Nm

  [[nodiscard]] bool empty() const noexcept { return *this == LabLimits(); }
  /// Adds limits: all regions of both, and the lower of two caps.
  /// @throws InputError naming a region that both have.
  void Add(const LabLimits& other);
  /// Lowers limits of the robot to the caps on speed.
  void Lower(JointLimits& limits) const noexcept;
  void Lower(CartesianLimits& limits) const noexcept;
  /// @throws InputError naming the limit and the value: a box that is empty, a normal of length 0,
  /// a name given twice, a cap that is not above 0, regions that leave a part no place.
  void Validate() const;
  bool operator==(const LabLimits&) const = default;
};

/// What the regions' parts are fixed to.
struct LimitedArm {
  Transform F_T_EE = kIdentityTransform;
  bool with_hand = true;  ///< a Franka Hand is mounted
};

/// The distance of one part from one plane that it must not pass,
///   margin = bound - outward . p - radius.
/// Beside a box to stay out of, the plane goes through the point of the box closest to the part,
/// perpendicular to the line between them.
struct RegionMargin {
  std::size_t region = 0;  ///< index in LabLimits::regions
  LimitedPart part{};
  Vector3 outward{};       ///< unit vector, base axes: where the margin falls
  double bound = 0;        ///< m
  double margin = 0;       ///< m; negative beyond the limit
  JointVector gradient{};  ///< of the margin by the joints, m/rad

  /// What the bound limits: how far the part reaches along `outward`, m.
  [[nodiscard]] double value() const noexcept { return bound - margin; }
};

/// Finds the planes closer to a part than a horizon.
/// @param horizon  m; infinite: all. @param near  receives the closest ones, as many as it takes,
/// in no particular order. Empty if q is not finite.
/// @returns the number of entries.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
[[nodiscard]] std::size_t MarginsWithin(double horizon, const LabLimits& limits,
                                        const LimitedArm& arm, const Configuration& q,
                                        std::span<RegionMargin> near) noexcept TWIN_REALTIME;

/// @returns the least margin of all; nullopt without regions, and if q is not finite.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
[[nodiscard]] std::optional<RegionMargin> LeastMargin(
    const LabLimits& limits, const LimitedArm& arm, const Configuration& q) noexcept TWIN_REALTIME;

/// As LeastMargin, of end effector and hand only, where no joint positions are known. Without
/// gradient. @param O_T_EE  pose of the end effector in the base.
[[nodiscard]] std::optional<RegionMargin> LeastMarginAt(
    const LabLimits& limits, const LimitedArm& arm, const Transform& O_T_EE) noexcept TWIN_REALTIME;

/// "limit \"table edge\": the hand reaches x = 0.71200 m; it must be at most 0.70000 m".
[[nodiscard]] std::string Describe(const LabLimits& limits, const RegionMargin& margin);

}  // namespace twin::model
