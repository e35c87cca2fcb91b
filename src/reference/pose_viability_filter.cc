#include "twin/reference/pose_viability_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "twin/core/time.h"
#include "twin/model/arm_model.h"
#include "twin/model/inverse_kinematics.h"
#include "twin/model/transform.h"

namespace twin::reference {
namespace {

using Eigen::Vector3d;

constexpr int kPoseHalvings = 16;  // between a motion that the joints can keep and the command
constexpr int kCorrections = 2;    // of the joints, after the first step; each squares the error

/// Twice the extra stopping distance of a pose, which brakes more gently than a joint.
constexpr double kShyOfTheEnds = 2e-3;  // rad

/// Usable share of the joints' limits: their motion is predicted, not commanded, and a loss holds
/// the pose's acceleration, not theirs.
constexpr double kForeseen = 0.9;

JointLimits Foreseen(JointLimits limits) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    limits.dq_max[i] *= kForeseen;
    limits.ddq_max[i] *= kForeseen;
    limits.dddq_max[i] *= kForeseen;
    limits.velocity_offset[i] *= kForeseen;  // and so the whole curve
    limits.deceleration[i] *= kForeseen * kForeseen;
  }
  return limits;
}

JointLimits Narrowed(JointLimits limits) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    limits.q_min[i] += kShyOfTheEnds;
    limits.q_max[i] -= kShyOfTheEnds;
  }
  return limits;
}

Vector3d First(const Vector6& x) noexcept {
  return Vector3d(x.data());
}
Vector3d Second(const Vector6& x) noexcept {
  return Vector3d(x.data() + 3);
}

/// The joints after the smallest step that reaches a pose.
JointVector JointsAt(const RobotState& state, const Transform& O_T_EE) noexcept {
  const model::ArmModel& arm = model::ArmModel::Panda();
  const Transform O_T_F = model::Multiply(O_T_EE, model::Inverse(state.F_T_EE));
  const model::FrameMotion flange = arm.MotionOf(model::Frame::kFlange, state.q_d);
  const model::InverseKinematics ik(flange.J);
  JointVector q = state.q_d;
  for (int i = 0; i <= kCorrections; ++i) {
    const Transform at = i == 0 ? flange.O_T_frame : arm.Pose(model::Frame::kFlange, q);
    const JointVector dq = ik.Solve(model::Displacement(at, O_T_F)).dq;
    for (std::size_t j = 0; j < kJoints; ++j) q[j] += dq[j];
  }
  return q;
}

}  // namespace

/// Start of a command's step.
struct PoseViabilityFilter::Step {
  Transform X;
  Vector3d v, dv, w, dw;

  explicit Step(const RobotState& state) noexcept
      : X(state.O_T_EE_c),
        v(First(state.O_dP_EE_c)),
        dv(First(state.O_ddP_EE_c)),
        w(Second(state.O_dP_EE_c)),
        dw(Second(state.O_ddP_EE_c)) {}

  [[nodiscard]] Transform After(const Twist& twist) const noexcept {
    return model::Turned(X, kT * twist.w, model::Position(X) + kT * twist.v);
  }
};

PoseViabilityFilter::Option PoseViabilityFilter::Between(const Option& a, const Option& b,
                                                         double share) noexcept {
  Option between{
      {a.twist.v + share * (b.twist.v - a.twist.v), a.twist.w + share * (b.twist.w - a.twist.w)},
      {}};
  for (std::size_t i = 0; i < kJoints; ++i) between.q[i] = a.q[i] + share * (b.q[i] - a.q[i]);
  return between;
}

PoseViabilityFilter::PoseViabilityFilter(const CartesianLimits& cartesian,
                                         const JointLimits& joints, int lost)
    : translation_(cartesian.translation, lost, "translation"),
      rotation_(cartesian.rotation, lost, "rotation"),
      joints_(Foreseen(joints), lost),
      narrow_(Narrowed(Foreseen(joints)), lost) {}

PoseViabilityFilter::Outcome PoseViabilityFilter::Next(const RobotState& state,
                                                       const Transform& O_T_EE_c) const noexcept {
  const Step from(state);
  const Twist wish{(model::Position(O_T_EE_c) - model::Position(from.X)) / kT,
                   model::TurnBetween(from.X, O_T_EE_c) / kT};
  const Twist kept = Kept(state, from, wish);
  if (kept.v == wish.v && kept.w == wish.w) return {O_T_EE_c, false};
  return {from.After(kept), true};
}

PoseViabilityFilter::TwistOutcome PoseViabilityFilter::NextTwist(
    const RobotState& state, const Vector6& O_dP_EE_c) const noexcept {
  const Step from(state);
  const Twist wish{First(O_dP_EE_c), Second(O_dP_EE_c)};
  const Twist kept = Kept(state, from, wish);
  if (kept.v == wish.v && kept.w == wish.w) return {O_dP_EE_c, false};
  return {{kept.v[0], kept.v[1], kept.v[2], kept.w[0], kept.w[1], kept.w[2]}, true};
}

PoseViabilityFilter::Twist PoseViabilityFilter::Kept(const RobotState& state, const Step& from,
                                                     const Twist& wish) const noexcept {
  const Twist saturated{translation_.Nearest(from.v, from.dv, wish.v),
                        rotation_.Nearest(from.w, from.dw, wish.w)};
  const JointVector q = JointsAt(state, from.After(saturated));
  return JointsCanKeep(state, q) ? saturated : Milder(state, from, {saturated, q});
}

PoseViabilityFilter::Twist PoseViabilityFilter::Milder(const RobotState& state, const Step& from,
                                                       const Option& wish) const noexcept {
  const auto option = [&](const Twist& twist) {
    return Option{twist, JointsAt(state, from.After(twist))};
  };
  const Option held = option({from.v + kT * from.dv, from.w + kT * from.dw});
  const Option slowed =
      option({translation_.Slowed(from.v, from.dv), rotation_.Slowed(from.w, from.dw)});
  const Option braked =
      option({translation_.Braked(from.v, from.dv), rotation_.Braked(from.w, from.dw)});
  std::optional<Option> mildest;
  double mildest_share = std::numeric_limits<double>::infinity();
  for (const Option& end : {slowed, braked}) {
    for (const double share : {1.0, 0.75, 0.5, 0.25, 0.0}) {
      const Option base = Between(held, end, share);
      if (!Allows(from, base.twist)) continue;
      if (JointsCanKeep(state, base.q)) return Towards(state, from, base, wish);
      const double worst = WorstShare(state, base.q);
      if (worst < mildest_share) {
        mildest_share = worst;
        mildest = base;
      }
    }
  }
  return mildest.value_or(braked).twist;
}

PoseViabilityFilter::Twist PoseViabilityFilter::Towards(const RobotState& state, const Step& from,
                                                        const Option& base,
                                                        const Option& wish) const noexcept {
  Twist best = base.twist;
  double good = 0;
  double bad = 1;
  for (int i = 0; i < kPoseHalvings; ++i) {
    const double middle = (good + bad) / 2;
    const Option between = Between(base, wish, middle);
    const bool kept = Allows(from, between.twist) && JointsCanKeep(state, between.q);
    (kept ? good : bad) = middle;
    if (kept) best = between.twist;
  }
  return best;
}

bool PoseViabilityFilter::Allows(const Step& from, const Twist& twist) const noexcept {
  return translation_.Allows(from.v, from.dv, twist.v) &&
         rotation_.Allows(from.w, from.dw, twist.w);
}

bool PoseViabilityFilter::JointsCanKeep(const RobotState& state,
                                        const JointVector& q) const noexcept {
  for (std::size_t i = 0; i < kJoints; ++i) {
    const ViableAxis& axis = joints_.axis(i);
    const AxisState x{state.q_d[i], state.dq_d[i], state.ddq_d[i]};
    const double jerk = ViableAxis::JerkToPosition(x, q[i]);
    if (!(std::abs(jerk) <= axis.kept().dddq_max)) return false;
    const AxisState next = ViableAxis::Step(x, jerk);
    const bool outwards = next.dq * (next.q - (axis.kept().q_min + axis.kept().q_max) / 2) > 0;
    if (!(outwards ? narrow_.axis(i) : axis).Contains(next)) return false;
  }
  return true;
}

double PoseViabilityFilter::WorstShare(const RobotState& state,
                                       const JointVector& q) const noexcept {
  double worst = 0;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const AxisBounds& kept = joints_.axis(i).kept();
    const double dq = (q[i] - state.q_d[i]) / kT;
    const double ddq = (dq - state.dq_d[i]) / kT;
    const double dddq = (ddq - state.ddq_d[i]) / kT;
    worst = std::max({worst, std::abs(dq) / kept.dq_max, std::abs(ddq) / kept.ddq_max,
                      std::abs(dddq) / kept.dddq_max});
  }
  return worst;
}

}  // namespace twin::reference
