#include "twin/plant/scene_capture.h"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cstddef>

namespace twin::plant {
namespace {

/// Force of a contact on its second geom's body, world axes.
Vector3 ForceOf(const mjModel& model, const mjData& data, int contact) noexcept {
  mjtNum wrench[6];
  mj_contactForce(&model, &data, contact, wrench);
  Vector3 force{};
  mju_mulMatTVec(force.data(), data.contact[contact].frame, wrench, 3, 3);
  return force;
}

void CaptureContacts(const mjModel& model, const mjData& data, rt::SceneRecord& scene) noexcept {
  scene.contacts = 0;
  for (int i = 0; i < data.ncon && scene.contacts < rt::SceneRecord::kMostContacts; ++i) {
    const mjContact& contact = data.contact[i];
    if (contact.exclude != 0 || contact.efc_address < 0) continue;
    rt::PointForce& mark = scene.contact[scene.contacts];
    std::copy_n(contact.pos, 3, mark.p_W.begin());
    mark.force_W = ForceOf(model, data, i);
    if (model.geom_bodyid[contact.geom1] > model.geom_bodyid[contact.geom2]) {
      mju_scl3(mark.force_W.data(), mark.force_W.data(), -1);
    }
    ++scene.contacts;
  }
}

/// The point p = c + (f x m) / f^2 on the force's line, nearest to the centre of mass c.
void CapturePushes(const mjModel& model, const mjData& data, rt::SceneRecord& scene) noexcept {
  constexpr mjtNum kLeast = 1e-6;  // N
  scene.pushes = 0;
  for (int body = 1; body < model.nbody && scene.pushes < rt::SceneRecord::kMostPushes; ++body) {
    const mjtNum* const force = data.xfrc_applied + std::ptrdiff_t{6} * body;
    const mjtNum square = mju_dot3(force, force);
    if (square < kLeast * kLeast) continue;
    rt::PointForce& mark = scene.push[scene.pushes++];
    std::copy_n(force, 3, mark.force_W.begin());
    mju_cross(mark.p_W.data(), force, force + 3);
    mju_scl3(mark.p_W.data(), mark.p_W.data(), 1 / square);
    mju_addTo3(mark.p_W.data(), data.xipos + std::ptrdiff_t{3} * body);
  }
}

}  // namespace

void CaptureScene(Time now, const TruthProbe& truth, rt::SceneRecord& scene) noexcept {
  scene.at = now;
  scene.positions = static_cast<std::uint32_t>(truth.qpos_size());
  truth.CopyQpos(std::span(scene.qpos).first(scene.positions));
  CaptureContacts(truth.model(), truth.data(), scene);
  CapturePushes(truth.model(), truth.data(), scene);
}

}  // namespace twin::plant
