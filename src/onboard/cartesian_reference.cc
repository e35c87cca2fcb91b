#include "twin/onboard/cartesian_reference.h"

#include <algorithm>

#include "twin/core/time.h"
#include "twin/model/arm_model.h"
#include "twin/model/transform.h"

namespace twin::onboard {
namespace {

Vector6 Rate(const Vector6& now, const Vector6& before) noexcept {
  Vector6 rate;
  for (std::size_t i = 0; i < 6; ++i) rate[i] = (now[i] - before[i]) / kT;
  return rate;
}

/// The pose one cycle later.
Transform Moved(const Transform& X, const Vector6& twist) noexcept {
  const Eigen::Map<const Eigen::Vector3d> v(twist.data());
  const Eigen::Map<const Eigen::Vector3d> w(twist.data() + 3);
  return model::Turned(X, kT * w, model::Position(X) + kT * v);
}

bool IsZero(const Vector6& x) noexcept {
  return std::all_of(x.begin(), x.end(), [](double value) { return value == 0; });
}

}  // namespace

CartesianReference CartesianReference::AfterPose(const Transform& O_T_EE) const noexcept {
  const Eigen::Vector3d phi = model::TurnBetween(O_T_EE_c, O_T_EE);
  CartesianReference next;
  next.O_T_EE_c = O_T_EE;
  for (std::size_t i = 0; i < 3; ++i) {
    next.O_dP_EE_c[i] = (O_T_EE[12 + i] - O_T_EE_c[12 + i]) / kT;
    next.O_dP_EE_c[3 + i] = phi[static_cast<Eigen::Index>(i)] / kT;
  }
  next.O_ddP_EE_c = Rate(next.O_dP_EE_c, O_dP_EE_c);
  next.O_dddP_EE_c = Rate(next.O_ddP_EE_c, O_ddP_EE_c);
  next.elbow_c = elbow_c;
  return next;
}

CartesianReference CartesianReference::AfterTwist(const Vector6& O_dP_EE) const noexcept {
  CartesianReference next;
  next.O_T_EE_c = Moved(O_T_EE_c, O_dP_EE);
  next.O_dP_EE_c = O_dP_EE;
  next.O_ddP_EE_c = Rate(O_dP_EE, O_dP_EE_c);
  next.O_dddP_EE_c = Rate(next.O_ddP_EE_c, O_ddP_EE_c);
  next.elbow_c = elbow_c;
  return next;
}

CartesianReference CartesianReference::AfterLoss() const noexcept {
  CartesianReference next = *this;
  for (std::size_t i = 0; i < 6; ++i) next.O_dP_EE_c[i] += kT * O_ddP_EE_c[i];
  next.O_T_EE_c = Moved(O_T_EE_c, next.O_dP_EE_c);
  next.O_dddP_EE_c = {};
  next.delbow_c += kT * ddelbow_c;
  next.elbow_c[0] += kT * next.delbow_c;
  next.dddelbow_c = 0;
  return next;
}

CartesianReference CartesianReference::WithElbow(const Elbow& elbow,
                                                 const CartesianReference& before) const noexcept {
  CartesianReference next = *this;
  next.elbow_c = elbow;
  next.delbow_c = (elbow[0] - before.elbow_c[0]) / kT;
  next.ddelbow_c = (next.delbow_c - before.delbow_c) / kT;
  next.dddelbow_c = (next.ddelbow_c - before.ddelbow_c) / kT;
  return next;
}

CartesianReference CartesianReference::WithElbowOf(const JointReference& joints) const noexcept {
  CartesianReference next = *this;
  next.elbow_c = model::ElbowOf(joints.q_d);
  next.delbow_c = joints.dq_d[2];
  next.ddelbow_c = joints.ddq_d[2];
  next.dddelbow_c = joints.dddq_d[2];
  return next;
}

bool CartesianReference::AtRest() const noexcept {
  return IsZero(O_dP_EE_c) && IsZero(O_ddP_EE_c) && delbow_c == 0 && ddelbow_c == 0;
}

CartesianReference CartesianReference::Rest(const Transform& O_T_EE, const Elbow& elbow) noexcept {
  CartesianReference reference;
  reference.O_T_EE_c = O_T_EE;
  reference.elbow_c = elbow;
  return reference;
}

}  // namespace twin::onboard
