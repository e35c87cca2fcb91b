#include "plant/brakes.h"

#include <algorithm>

namespace twin::plant {

Brakes::Brakes(const mjModel& model, const std::array<int, kJoints>& dofs,
               const JointVector& tau_max) noexcept
    : dofs_(dofs), tau_max_(tau_max) {
  for (std::size_t i = 0; i < kJoints; ++i) friction_[i] = model.dof_frictionloss[dofs_[i]];
}

void Brakes::Reset(mjModel& model) noexcept {
  for (std::size_t i = 0; i < kJoints; ++i) model.dof_frictionloss[dofs_[i]] = friction_[i];
  carried_ = {};
  closed_ = false;
}

void Brakes::Set(bool closed, mjModel& model, mjData& data) {
  if (closed == closed_) return;
  Reset(model);
  closed_ = closed;
  if (closed) {
    for (std::size_t i = 0; i < kJoints; ++i) {
      model.dof_frictionloss[dofs_[i]] = std::max(friction_[i], tau_max_[i]);
    }
  }
  // The constraints of the next step already exist; recompute them.
  mj_step1(&model, &data);
}

JointVector Brakes::Take(const mjData& data) noexcept {
  JointVector torque{};
  if (!closed_) return torque;
  for (int row = 0; row < data.nefc; ++row) {
    if (data.efc_type[row] != mjCNSTR_FRICTION_DOF) continue;
    for (std::size_t i = 0; i < kJoints; ++i) {
      if (data.efc_id[row] != dofs_[i]) continue;
      torque[i] = carried_[i] + data.efc_force[row];
      carried_[i] = std::clamp(torque[i], -tau_max_[i], tau_max_[i]);
    }
  }
  return torque;
}

}  // namespace twin::plant
