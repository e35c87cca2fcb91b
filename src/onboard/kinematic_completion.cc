#include "twin/onboard/kinematic_completion.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "twin/core/time.h"
#include "twin/model/inverse_kinematics.h"
#include "twin/model/transform.h"

namespace twin::onboard {
namespace {

using model::Configuration;
using model::Frame;
using model::InverseKinematics;

constexpr std::size_t kElbowJoint = 2;    // joint 3
constexpr std::size_t kStretchJoint = 3;  // joint 4

/// The error after the first step is of second order in the change of a step, 1e-10 at the limits
/// of jerk; each correction reduces it by another factor of a step's length, 1e-3.
constexpr int kMaxCorrections = 3;
constexpr double kCorrectedWell = 1e-13;
/// Steps below this are withheld, rad: the error that kCorrectedWell leaves, times the joints'
/// largest gain, 1 / kDampedBelow, and a margin. A lag below it is zero, m and rad.
constexpr double kNoStep = 1e-11;
constexpr double kNoLag = 1e-12;

template <std::size_t N>
double Largest(const std::array<double, N>& x) noexcept {
  double largest = 0;
  for (const double value : x) largest = std::max(largest, std::abs(value));
  return largest;
}

template <std::size_t N>
std::array<double, N> Sum(const std::array<double, N>& a, const std::array<double, N>& b) noexcept {
  std::array<double, N> sum;
  for (std::size_t i = 0; i < N; ++i) sum[i] = a[i] + b[i];
  return sum;
}

Vector6 Difference(const Vector6& a, const Vector6& b) noexcept {
  Vector6 difference;
  for (std::size_t i = 0; i < 6; ++i) difference[i] = a[i] - b[i];
  return difference;
}

/// Step of joint 4 away from the flip angle.
double Repulsion(double q4) noexcept {
  const double distance = std::abs(q4 - model::kElbowFlipAngle);
  if (distance >= KinematicCompletion::kKeptClear) return 0;
  const double depth = 1 - distance / KinematicCompletion::kKeptClear;
  return std::copysign(kT * KinematicCompletion::kRepulsion * depth * depth * depth,
                       q4 - model::kElbowFlipAngle);
}

/// The lag of the next cycle: it decays with the time constant, a large one at the greatest speed.
Vector6 Remaining(const Vector6& lag) noexcept {
  constexpr double kSoft = KinematicCompletion::kCatchUpSpeed * KinematicCompletion::kCatchUpTime;
  Vector6 remaining = lag;
  for (const std::size_t block : {0, 3}) {
    const double* x = &lag[block];
    const double length = std::sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
    const double share = kT / KinematicCompletion::kCatchUpTime / (1 + length / kSoft);
    for (std::size_t i = 0; i < 3; ++i) remaining[block + i] -= share * lag[block + i];
  }
  return remaining;
}

/// The step of the joints at constant acceleration.
JointVector Ahead(const JointReference& from, const std::optional<double>& elbow) noexcept {
  JointVector step;
  for (std::size_t i = 0; i < kJoints; ++i) step[i] = kT * (from.dq_d[i] + kT * from.ddq_d[i]);
  if (elbow) step[kElbowJoint] = *elbow - from.q_d[kElbowJoint];
  return step;
}

JointVector Velocity(const JointVector& from, const JointVector& to) noexcept {
  JointVector dq;
  for (std::size_t i = 0; i < kJoints; ++i) dq[i] = (to[i] - from[i]) / kT;
  return dq;
}

/// The damped step from q_d, linearised at the predicted joints: its error is of second order in
/// the change of the step.
struct FirstStep {
  InverseKinematics ik;
  JointVector dq{};
  Vector6 missed{};     ///< the part that the damping leaves out
  bool is_free = true;  ///< neither damped nor repelled from the flip angle
};

/// @param error_at  of a pose of the flange: its remaining displacement.
template <typename ErrorAt>
FirstStep StepOf(const JointReference& from, const std::optional<double>& elbow,
                 const ErrorAt& error_at) noexcept {
  JointVector ahead = Ahead(from, elbow);
  const double elbow_step = ahead[kElbowJoint];
  const Configuration expected(Sum(from.q_d, ahead));
  const model::FrameMotion flange = model::ArmModel::Panda().MotionOf(Frame::kFlange, expected);
  FirstStep first{InverseKinematics(flange.J, {.joint_3_moves = !elbow,
                                               .s_0 = KinematicCompletion::kDampedBelow,
                                               .lambda_max = KinematicCompletion::kDampedBelow})};
  JointVector away{};
  away[kStretchJoint] = Repulsion(from.q_d[kStretchJoint]);
  first.is_free = first.ik.damping() == 0 && away[kStretchJoint] == 0;
  if (elbow) ahead[kElbowJoint] = 0;
  for (std::size_t i = 0; i < kJoints; ++i) ahead[i] -= away[i];
  const auto [dq, missed] = first.ik.Solve(Sum(error_at(flange.O_T_frame), first.ik.Moved(ahead)));
  first.dq = Sum(dq, away);
  if (elbow) first.dq[kElbowJoint] = elbow_step;
  first.missed = missed;
  return first;
}

}  // namespace

KinematicCompletion::KinematicCompletion(const Transform& F_T_EE) noexcept : F_T_EE_(F_T_EE) {
  const Transform EE_T_F = model::Inverse(F_T_EE);
  EE_p_F_ = {EE_T_F[12], EE_T_F[13], EE_T_F[14]};
}

Vector6 KinematicCompletion::ErrorAtFlange(const Transform& O_T_EE, const Transform& O_T_EE_c,
                                           const Lag& lag) const noexcept {
  Vector6 x = Difference(model::Displacement(O_T_EE, O_T_EE_c), lag);
  Vector3 arm;  // from EE to the flange, base axes
  for (std::size_t i = 0; i < 3; ++i) {
    arm[i] = O_T_EE[i] * EE_p_F_[0] + O_T_EE[4 + i] * EE_p_F_[1] + O_T_EE[8 + i] * EE_p_F_[2];
  }
  x[0] += x[4] * arm[2] - x[5] * arm[1];
  x[1] += x[5] * arm[0] - x[3] * arm[2];
  x[2] += x[3] * arm[1] - x[4] * arm[0];
  return x;
}

KinematicCompletion::Step KinematicCompletion::Complete(
    const JointReference& from, const Lag& lag, const Transform& O_T_EE_c,
    const std::optional<double>& elbow) const noexcept {
  const model::ArmModel& arm = model::ArmModel::Panda();
  const bool lagged = Largest(lag) > 0;
  const Lag remaining = lagged ? Remaining(lag) : lag;
  const FirstStep first = StepOf(from, elbow, [&](const Transform& O_T_F) {
    return ErrorAtFlange(model::Multiply(O_T_F, F_T_EE_), O_T_EE_c, remaining);
  });
  Step result;
  JointVector step = first.dq;
  for (int i = 0; true; ++i) {
    result.q_d = Largest(step) < kNoStep ? from.q_d : Sum(from.q_d, step);
    if (elbow) result.q_d[kElbowJoint] = *elbow;
    std::tie(result.O_T_EE_d, result.O_dP_EE_d) =
        arm.PoseAndTwist(Frame::kEndEffector, result.q_d, Velocity(from.q_d, result.q_d), F_T_EE_);
    const Vector6 left =
        Difference(ErrorAtFlange(result.O_T_EE_d, O_T_EE_c, remaining), first.missed);
    if (Largest(left) < kCorrectedWell || i == kMaxCorrections) break;
    step = Sum(step, first.ik.Solve(left).dq);
  }
  if (!first.is_free) {
    result.lag = model::Displacement(result.O_T_EE_d, O_T_EE_c);
  } else if (lagged && Largest(remaining) > kNoLag) {
    result.lag = remaining;
  }
  return result;
}

bool KinematicCompletion::IsSingular(const JointVector& q) const noexcept {
  return std::abs(q[kStretchJoint] - model::kElbowFlipAngle) < kKeptClear ||
         InverseKinematics(model::ArmModel::Panda().ZeroJacobian(Frame::kFlange, q)).dexterity() <
             kSingularBelow;
}

}  // namespace twin::onboard
