#pragma once

#include <mujoco/mujoco.h>

#include "twin/core/joint_vector.h"

namespace twin::plant {

/// Adds a wrench to what acts on a body in the next step: the engine takes it at the body's centre
/// of mass. @param force  at the point p. All in world axes. @pre data.xipos is of the state before
/// that step.
inline void AddWrench(const Vector3& force, const Vector3& torque, const Vector3& p, int body,
                      mjData& data) noexcept {
  mjtNum arm[3];
  mju_sub3(arm, p.data(), data.xipos + 3 * body);
  mjtNum moment[3];
  mju_cross(moment, arm, force.data());
  mju_addTo3(moment, torque.data());
  mju_addTo3(data.xfrc_applied + 6 * body, force.data());
  mju_addTo3(data.xfrc_applied + 6 * body + 3, moment);
}

}  // namespace twin::plant
