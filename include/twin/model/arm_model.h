#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/model/mass_properties.h"
#include "twin/model/payload.h"

namespace twin::model {

/// 6 x 7 matrix, column-major: element (row r, joint j) is index 6 j + r, rows vx vy vz wx wy wz.
using Jacobian = std::array<double, 6 * kJoints>;

/// 7 x 7 matrix, column-major: element (row r, column c) is index 7 c + r.
using JointMatrix = std::array<double, kJoints * kJoints>;

/// The frames of the arm. Joint frames follow the modified DH convention: frame n is fixed to link
/// n, its z axis is the axis of joint n.
enum class Frame : std::uint8_t {
  kJoint1,
  kJoint2,
  kJoint3,
  kJoint4,
  kJoint5,
  kJoint6,
  kJoint7,
  kFlange,
  kEndEffector,  ///< the flange times F_T_EE
};

/// Joint positions with their sines and cosines. Every call of ArmModel takes one; a JointVector
/// becomes one by itself. Who makes several calls at the same q builds it once and saves the sines.
///
/// Real-time: noexcept, allocates nothing.
struct Configuration {
  /// @param q  7, joint order, rad.
  // NOLINTNEXTLINE(google-explicit-constructor): a JointVector is meant to become one by itself.
  Configuration(const JointVector& q) noexcept TWIN_REALTIME;

  JointVector sin{};
  JointVector cos{};
};

/// A frame and how the joints move it.
struct FrameMotion {
  Transform O_T_frame = kIdentityTransform;
  Jacobian J{};  ///< zero Jacobian
};

/// Rigid-body model of the Panda arm: seven joints, kinematics fixed, inertial parameters given.
///
///   M(q) ddq + C(q, dq) dq + g(q) = tau
///
/// M, C and g are those of the links and of the payload alone: no rotor inertia, no friction.
/// Everything beyond the flange enters through the payload.
/// Source of the kinematics: Franka Control Interface documentation, Denavit-Hartenberg parameters
/// of Panda. Source of names and conventions: the model library of FCI protocol 5.
///
/// Parameters of the calls: q rad; dq rad/s; ddq rad/s^2; F_T_EE end effector in the flange frame,
/// read for Frame::kEndEffector only; payload everything beyond the flange, of whose inertia the
/// symmetric part counts; g_earth gravity in base axes, m/s^2.
///
/// Threads: any (immutable). Real-time: all calls are noexcept and allocate nothing. No
/// argument is checked: what is not finite gives a result that is not.
class ArmModel {
 public:
  /// What the real robot's own model library answers, by a fit to it: M, c and g of the bare arm to
  /// rounding, by its author's account. With a load the real library's M is not affine in the mass,
  /// ours is: up to 18 g apart. Single links are not physical (some have negative inertias); the M
  /// they make is positive definite.
  /// Source: franka-rs (Apache-2.0), crates/franka-rs/tests/data/fer.urdf.
  [[nodiscard]] static const ArmModel& Panda() noexcept TWIN_REALTIME;

  /// The figures the twin's own plant is made of: gravity as Panda() within 1e-3 Nm, but inertias
  /// that a body can have. M differs from Panda() by up to 0.06 kg m^2, 2.4 % on average.
  /// Source: masses and centres of mass of franka_emulator (MIT), model.urdf; inertias of Gaz et
  /// al., "Dynamic Identification of the Franka Emika Panda Robot With Retrieval of Feasible
  /// Parameters Using Penalty-Based Optimization", RA-L 2019.
  [[nodiscard]] static const ArmModel& PandaPlant() noexcept TWIN_REALTIME;

  /// @param links  7, joint order, without payload.
  explicit constexpr ArmModel(const std::array<LinkParameters, kJoints>& links) noexcept {
    for (std::size_t i = 0; i < kJoints; ++i) {
      links_[i] = MassMoments::Of(links[i].m, links[i].com, links[i].I);
    }
  }

  /// @returns pose of the frame in the base, O_T_frame.
  [[nodiscard]] Transform Pose(Frame frame, const Configuration& q,
                               const Transform& F_T_EE = kIdentityTransform) const noexcept
      TWIN_REALTIME;

  /// @returns J with J dq = twist of the frame's origin in base axes. Columns of joints beyond the
  /// frame are zero.
  [[nodiscard]] Jacobian ZeroJacobian(Frame frame, const Configuration& q,
                                      const Transform& F_T_EE = kIdentityTransform) const noexcept
      TWIN_REALTIME;

  /// @returns Pose() and ZeroJacobian() at once, for little more than one of them.
  [[nodiscard]] FrameMotion MotionOf(Frame frame, const Configuration& q,
                                     const Transform& F_T_EE = kIdentityTransform) const noexcept
      TWIN_REALTIME;

  /// @returns J with J dq = the same twist in the frame's own axes.
  [[nodiscard]] Jacobian BodyJacobian(Frame frame, const Configuration& q,
                                      const Transform& F_T_EE = kIdentityTransform) const noexcept
      TWIN_REALTIME;

  /// @returns ZeroJacobian(frame, q, F_T_EE) dq, without forming the matrix: [v; w], m/s, rad/s.
  [[nodiscard]] Vector6 Twist(Frame frame, const Configuration& q, const JointVector& dq,
                              const Transform& F_T_EE = kIdentityTransform) const noexcept
      TWIN_REALTIME;

  /// @returns M(q), kg m^2.
  [[nodiscard]] JointMatrix MassMatrix(const Configuration& q,
                                       const Payload& payload) const noexcept TWIN_REALTIME;

  /// @returns the torque C(q, dq) dq, Nm.
  [[nodiscard]] JointVector Coriolis(const Configuration& q, const JointVector& dq,
                                     const Payload& payload) const noexcept TWIN_REALTIME;

  /// @returns g(q), the torque that holds the arm, Nm.
  [[nodiscard]] JointVector Gravity(const Configuration& q, const Payload& payload,
                                    const Vector3& g_earth = {0, 0,
                                                              -9.81}) const noexcept TWIN_REALTIME;

  /// @returns M(q) ddq + C(q, dq) dq + g(q) in one recursion, Nm.
  [[nodiscard]] JointVector InverseDynamics(const Configuration& q, const JointVector& dq,
                                            const JointVector& ddq, const Payload& payload,
                                            const Vector3& g_earth = {
                                                0, 0, -9.81}) const noexcept TWIN_REALTIME;

 private:
  std::array<MassMoments, kJoints> links_{};  // each about its joint frame's origin
};

/// Angle of joint 4 at which the arm is stretched most, rad. Source: libfranka,
/// RobotState::elbow.
inline constexpr double kElbowFlipAngle = -0.467002423653011;

/// @returns angle of joint 3 and the sign of the elbow flip: +1 if q4 is above kElbowFlipAngle, -1
/// if below, 0 if equal. Usual configurations give -1.
/// Source: FCI protocol 5; libfranka documentation of `elbow`.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
[[nodiscard]] Elbow ElbowOf(const JointVector& q) noexcept TWIN_REALTIME;

}  // namespace twin::model
