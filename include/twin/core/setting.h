#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "twin/core/joint_vector.h"

// Settings of the robot that change while no motion runs, one struct per FCI request. kName is the
// request as clients of the real robot print it. Defaults are the robot's after start, where known.
// Source: FCI protocol 5, commands and defaults.
namespace twin::setting {

/// Stiffness of the internal joint impedance controller.
struct JointImpedance {
  static constexpr std::string_view kName = "Set Joint Impedance";
  JointVector K_theta{3000, 3000, 3000, 2500, 2500, 2000, 2000};  ///< Nm/rad, each in [0, 14250]
  bool operator==(const JointImpedance&) const = default;
};

/// Stiffness of the internal Cartesian impedance controller, along and about the axes of K.
struct CartesianImpedance {
  static constexpr std::string_view kName = "Set Cartesian Impedance";
  /// x y z in [10, 3000] N/m; R P Y in [1, 300] Nm/rad.
  Vector6 K_x{3000, 3000, 3000, 300, 300, 300};
  bool operator==(const CartesianImpedance&) const = default;
};

/// Above a lower threshold the robot reports a contact; above an upper one it stops with a reflex.
/// The `acc` set counts while the reference accelerates, the `nominal` one otherwise. Each >= 0,
/// lower <= upper. The factory's values are not public; these are set by the vendor's ROS package
/// and motion examples.
struct CollisionBehavior {
  static constexpr std::string_view kName = "Set Collision Behavior";
  JointVector lower_torque_acc{20, 20, 18, 18, 16, 14, 12};  ///< Nm
  JointVector upper_torque_acc = lower_torque_acc;
  JointVector lower_torque_nominal = lower_torque_acc;
  JointVector upper_torque_nominal = lower_torque_acc;
  Vector6 lower_force_acc{20, 20, 20, 25, 25, 25};  ///< N, Nm; in K
  Vector6 upper_force_acc = lower_force_acc;
  Vector6 lower_force_nominal = lower_force_acc;
  Vector6 upper_force_nominal = lower_force_acc;
  bool operator==(const CollisionBehavior&) const = default;
};

/// Axes of the base along and about which people can lead the arm in guiding mode.
struct GuidingMode {
  static constexpr std::string_view kName = "Set Guiding Mode";
  std::array<bool, 6> axes{true, true, true, true, true, true};  ///< x y z R P Y; true: free
  bool elbow = true;                                             ///< the null space is free
  bool operator==(const GuidingMode&) const = default;
};

/// The stiffness frame K in EE.
struct StiffnessFrame {
  static constexpr std::string_view kName = "Set EE to K";
  Transform EE_T_K = kIdentityTransform;
  bool operator==(const StiffnessFrame&) const = default;
};

/// The end effector EE in the nominal end effector NE.
struct EndEffectorFrame {
  static constexpr std::string_view kName = "Set NE to EE";
  Transform NE_T_EE = kIdentityTransform;
  bool operator==(const EndEffectorFrame&) const = default;
};

/// Load beyond the end effector, as configured.
struct Load {
  static constexpr std::string_view kName = "Set Load";
  double m_load = 0;    ///< kg, >= 0
  Vector3 F_x_Cload{};  ///< centre of mass in the flange frame, m
  Matrix3 I_load{};     ///< about it, flange axes, kg m^2; IsInertiaOfBody()
  bool operator==(const Load&) const = default;
};

/// Cut-off frequencies of the robot's low-passes on commands, Hz, each in [1, 1000]; 1000: off.
struct Filters {
  static constexpr std::string_view kName = "Set Filters";
  double joint_position_hz = 1000;
  double joint_velocity_hz = 1000;
  double cartesian_position_hz = 1000;
  double cartesian_velocity_hz = 1000;
  double controller_hz = 1000;  ///< on the torque of an external controller
  bool operator==(const Filters&) const = default;
};

}  // namespace twin::setting

namespace twin {

using Setting =
    std::variant<setting::JointImpedance, setting::CartesianImpedance, setting::CollisionBehavior,
                 setting::GuidingMode, setting::StiffnessFrame, setting::EndEffectorFrame,
                 setting::Load, setting::Filters>;

/// An invalid value in a setting.
struct BadValue {
  std::string_view field;       ///< "K_theta", ...
  std::optional<int> index;     ///< of the element; absent: the whole field
  std::optional<double> value;  ///< as given; absent: the whole field is wrong
  std::string_view allowed;     ///< "in [0, 14250] Nm/rad", "a rigid transform", ...
};

/// "K_theta[3] is -1; it must be in [0, 14250] Nm/rad".
[[nodiscard]] std::string Describe(const BadValue& bad);

/// Finds the first value that is out of range or not finite, a transform that is not rigid or
/// beyond 10 m, or a load that no body can have (without mass no inertia, else IsInertiaOfBody).
///
/// Threads: any. Real-time: noexcept, allocates nothing.
[[nodiscard]] std::optional<BadValue> FindBadValue(const Setting& setting) noexcept;

/// The setting's kName: "Set Joint Impedance", ...
[[nodiscard]] std::string_view Name(const Setting& setting) noexcept;

/// Whether X is rigid within 1e-5: rotation orthonormal and right-handed, last row (0, 0, 0, 1).
[[nodiscard]] bool IsRigid(const Transform& X) noexcept;

/// Whether a body can have this inertia, about its centre of mass: symmetric, and
///   Sigma = tr(I)/2 1 - I >= 0,
/// i.e. no principal moment is negative or exceeds the sum of the other two. Rods and points, with
/// zero moments, are limit cases and allowed. Tolerance: 1e-6 of the trace, for rounding in
/// rotation and output.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
[[nodiscard]] bool IsInertiaOfBody(const Matrix3& I) noexcept;

}  // namespace twin
