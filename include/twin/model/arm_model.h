#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/model/mass_properties.h"

namespace twin::model {

/// 6 x 7 matrix, column-major: element (row r, joint j) is index 6 j + r, rows vx vy vz wx wy wz.
using Jacobian = std::array<double, 6 * kJoints>;

/// Bodies of a regressor: the seven links, then what is on the flange.
inline constexpr std::size_t kRegressorBodies = kJoints + 1;
/// Parameters of a body: its MassMoments m, hx, hy, hz, Ixx, Ixy, Ixz, Iyy, Iyz, Izz.
inline constexpr std::size_t kBodyParameters = 10;
/// 7 x 80 matrix, row-major: element (joint j, parameter p of body b) is index 80 j + 10 b + p.
using Regressor = std::array<double, kJoints * kRegressorBodies * kBodyParameters>;

/// 7 x 7 matrix, column-major: element (row r, column c) is index 7 c + r.
using JointMatrix = std::array<double, kJoints * kJoints>;

/// Frames of the arm. Joint frames follow the modified DH convention: frame n is fixed to link n,
/// with its z axis along joint n.
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

/// Joint positions with sines and cosines, the argument of ArmModel's calls. A JointVector converts
/// implicitly; construct one explicitly to share the sines between calls at the same q.
///
/// Real-time: noexcept, allocates nothing.
struct Configuration {
  /// @param q  7, joint order, rad.
  // NOLINTNEXTLINE(google-explicit-constructor): a JointVector converts on purpose.
  Configuration(const JointVector& q) noexcept TWIN_REALTIME;

  JointVector sin{};
  JointVector cos{};
};

/// Pose and Jacobian of a frame.
struct FrameMotion {
  Transform O_T_frame = kIdentityTransform;
  Jacobian J{};  ///< zero Jacobian
};

/// Rigid-body model of the Panda arm: seven joints, fixed kinematics, given inertial parameters.
///
///   M(q) ddq + C(q, dq) dq + g(q) = tau
///
/// M, C and g include links and payload only, without rotor inertia and friction. The payload holds
/// everything beyond the flange.
/// Source of the kinematics: Franka Control Interface documentation, Denavit-Hartenberg parameters
/// of Panda. Source of names and conventions: the model library of FCI protocol 5.
///
/// Parameters: q rad; dq rad/s; ddq rad/s^2; F_T_EE end effector in the flange frame, used for
/// Frame::kEndEffector only; payload everything beyond the flange, with the symmetric part of its
/// inertia; g_earth gravity in base axes, m/s^2.
///
/// Threads: any (immutable). Real-time: all calls are noexcept and allocate nothing. Arguments are
/// not checked: values that are not finite give results that are not finite.
class ArmModel {
 public:
  /// A fit to the real robot's model library: M, c and g of the bare arm up to rounding, according
  /// to its author. With a load, the real library's M is not affine in the mass but ours is; their
  /// difference corresponds to up to 18 g. Single links are not physical (some have negative
  /// inertias), but the resulting M is positive definite.
  /// Source: franka-rs (Apache-2.0), crates/franka-rs/tests/data/fer.urdf.
  [[nodiscard]] static const ArmModel& Panda() noexcept TWIN_REALTIME;

  /// The parameters of the twin's plant: gravity equals that of Panda() within 1e-3 Nm, with
  /// physical inertias. M differs from Panda() by up to 0.06 kg m^2, 2.4 % on average.
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

  /// @returns J with J dq = twist of the frame's origin in base axes. Columns of joints that do not
  /// move the frame are zero.
  [[nodiscard]] Jacobian ZeroJacobian(Frame frame, const Configuration& q,
                                      const Transform& F_T_EE = kIdentityTransform) const noexcept
      TWIN_REALTIME;

  /// @returns Pose() and ZeroJacobian() together, at little more than the cost of one.
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

  /// @returns Pose() and Twist() together, at little more than the cost of one.
  [[nodiscard]] std::pair<Transform, Vector6> PoseAndTwist(
      Frame frame, const Configuration& q, const JointVector& dq,
      const Transform& F_T_EE = kIdentityTransform) const noexcept TWIN_REALTIME;

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

  /// @returns Y with Y pi = InverseDynamics() for the parameters pi of links (each about its joint
  /// frame's origin, in its axes) and of a body on the flange (the flange's). Depends on no model:
  /// all share the kinematics. Source: Atkeson, An, Hollerbach, "Estimation of Inertial Parameters
  /// of Manipulator Loads and Links", IJRR 1986.
  [[nodiscard]] static Regressor RegressorOf(const Configuration& q, const JointVector& dq,
                                             const JointVector& ddq,
                                             const Vector3& g_earth = {
                                                 0, 0, -9.81}) noexcept TWIN_REALTIME;

  /// @returns the links' parameters, joint order, each about its joint frame's origin.
  [[nodiscard]] const std::array<MassMoments, kJoints>& links() const noexcept { return links_; }

 private:
  std::array<MassMoments, kJoints> links_{};  // each about its joint frame's origin
};

/// Angle of joint 4 at the greatest extension of the arm, rad. Source: libfranka,
/// RobotState::elbow.
inline constexpr double kElbowFlipAngle = -0.467002423653011;

/// @returns angle of joint 3 and the sign of the elbow flip: +1 if q4 is above kElbowFlipAngle, -1
/// if below, 0 if equal. Usual configurations give -1.
/// Source: FCI protocol 5; libfranka documentation of `elbow`.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
[[nodiscard]] Elbow ElbowOf(const JointVector& q) noexcept TWIN_REALTIME;

/// Residual link-side friction of the Panda's joints, after the robot's own compensation of motor
/// and gear:
///   tau_f(dq) = phi1 / (1 + exp(-phi2 (dq + phi3))) - phi1 / (1 + exp(-phi2 phi3)),
/// opposed to dq, zero at rest and smooth there. Source: Gaz, Cognetti, Oliva, Robuffo Giordano,
/// De Luca, "Dynamic Identification of the Franka Emika Panda Robot with Retrieval of Feasible
/// Parameters Using Penalty-Based Optimization", RA-L 2019, supplementary material.
///
/// Threads: any (stateless). Real-time: noexcept, allocates nothing.
/// @param dq  7, joint order, rad/s. @returns friction torque that opposes the motion, Nm.
[[nodiscard]] JointVector ResidualFriction(const JointVector& dq) noexcept TWIN_REALTIME;

}  // namespace twin::model
