#include "plant/hand_joints.h"

namespace twin::plant {
namespace {

constexpr double kFriction = 10;  // D, N s/m: 0.5 N at the hand's full speed; not public

// Belt, for a finger's inertia of 1 kg: 80 Hz, half of critical damping.
constexpr double kBeltStiffness = 1.25e5;  // K, N/m
constexpr double kBeltDamping = 250;       // C, N s/m

}  // namespace

HandJoints::HandJoints(const mjModel& model, const RobotDescription& robot) noexcept {
  std::size_t i = 0;
  for (const Link& link : robot.links) {
    if (link.joint_kind != JointKind::kPrismatic) continue;
    const int joint = mj_name2id(&model, mjOBJ_JOINT, link.joint.c_str());
    fingers_[i].qpos = model.jnt_qposadr[joint];
    fingers_[i].dof = model.jnt_dofadr[joint];
    open_ = link.q_max;
    ++i;
  }
}

void HandJoints::Reset(mjData& data) noexcept {
  for (const Finger& finger : fingers_) data.qpos[finger.qpos] = open_;
  drive_ = {.force = 0, .width_d = 2 * open_};
  sensors_ = {.width = 2 * open_, .dwidth = 0, .force = 0};
}

void HandJoints::Apply(mjData& data) const noexcept {
  const auto& [a, b] = fingers_;
  const double dx_a = data.qvel[a.dof];
  const double dx_b = data.qvel[b.dof];
  const double belt =
      kBeltStiffness * (data.qpos[a.qpos] - data.qpos[b.qpos]) + kBeltDamping * (dx_a - dx_b);
  data.qfrc_applied[a.dof] = drive_.force - kFriction * dx_a - belt;
  data.qfrc_applied[b.dof] = drive_.force - kFriction * dx_b + belt;
}

void HandJoints::Sense(const mjData& data) noexcept {
  const auto& [a, b] = fingers_;
  const double before = sensors_.dwidth;
  sensors_.width = data.qpos[a.qpos] + data.qpos[b.qpos];
  sensors_.dwidth = data.qvel[a.dof] + data.qvel[b.dof];
  sensors_.force = drive_.force - kFriction * before / 2 -
                   kFingerInertia * (data.qacc[a.dof] + data.qacc[b.dof]) / 2;
}

}  // namespace twin::plant
