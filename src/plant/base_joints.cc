#include "plant/base_joints.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "plant/model_builder.h"
#include "plant/part_names.h"
#include "twin/core/error.h"

namespace twin::plant {
namespace {

constexpr int kSettlingSteps = 500;

/// Velocity of a body's point, world axes. @param p  from the body's origin, world axes.
Vector3 VelocityAt(const mjModel& model, const mjData& data, int body, const Vector3& p) noexcept {
  mjtNum twist[6];  // [w; v] of the body's origin, world axes
  mj_objectVelocity(&model, &data, mjOBJ_XBODY, body, twist, 0);
  Vector3 v{};
  mju_cross(v.data(), twist, p.data());
  mju_addTo3(v.data(), twist + 3);
  return v;
}

/// Contacts of a body and of bodies fixed to it: ": block, table"; empty without any.
std::string NamesInTheWay(const mjModel& model, int body) {
  const ModelParts parts(model);
  const DataPointer data(mj_makeData(&model));
  mj_fwdPosition(&model, data.get());
  std::set<std::string> names;
  for (int i = 0; i < data->ncon; ++i) {
    const int geoms[2]{data->contact[i].geom1, data->contact[i].geom2};
    for (const int side : {0, 1}) {
      const int mine = model.body_weldid[model.geom_bodyid[geoms[side]]];
      if (mine == body) names.insert(parts.names.at(parts.of_geom[geoms[1 - side]]));
    }
  }
  return names.empty() ? std::string() : fmt::format(": {}", fmt::join(names, ", "));
}

}  // namespace

BaseJoints::BaseJoints(const mjModel& model, const RobotDescription& robot) {
  const int root = mj_name2id(&model, mjOBJ_JOINT, robot.links.front().joint.c_str());
  body_ = model.jnt_bodyid[root];
  qpos_ = model.jnt_qposadr[root];
  dof_ = model.jnt_dofadr[root];
  for (std::size_t i = 0; i < kWheels.size(); ++i) {
    const Link* link = robot.Find(kWheels[i]);
    const int joint = mj_name2id(&model, mjOBJ_JOINT, link->joint.c_str());
    wheels_[i].body = mj_name2id(&model, mjOBJ_BODY, kWheels[i]);
    wheels_[i].qpos = model.jnt_qposadr[joint];
    wheels_[i].dof = model.jnt_dofadr[joint];
    wheels_[i].radius = link->collision.front().size[0];
  }
}

BaseJoints::Wheel* BaseJoints::Find(int body) noexcept {
  for (Wheel& wheel : wheels_) {
    if (wheel.body == body) return &wheel;
  }
  return nullptr;
}

void BaseJoints::Settle(const mjModel& model, mjData& data) {
  const std::vector<mjtNum> before(data.qpos, data.qpos + model.nq);
  drive_ = {};
  for (Wheel& wheel : wheels_) {
    wheel.load = {};
    wheel.tyre.Reset();
  }
  mj_forward(&model, &data);
  for (int k = 0; k < kSettlingSteps; ++k) {
    // Everything else is fixed meanwhile: the arm keeps its pose, wheels and objects do not move.
    std::copy_n(data.qfrc_bias, model.nv, data.qfrc_applied);
    Apply(model, data);
    mj_step2(&model, &data);
    Take(model, data);
    for (int dof = 0; dof < model.nv; ++dof) {
      if (dof < dof_ || dof >= dof_ + 6) data.qvel[dof] = 0;
    }
    for (int i = 0; i < model.nq; ++i) {
      if (i < qpos_ || i >= qpos_ + 7) data.qpos[i] = before[static_cast<std::size_t>(i)];
    }
    mj_step1(&model, &data);
  }
  std::copy_n(before.begin() + qpos_, 2, data.qpos + qpos_);
  for (mjtNum* const values : {data.qvel, data.qacc_warmstart, data.qfrc_applied}) {
    std::fill_n(values, model.nv, 0.0);
  }
  data.time = 0;
}

void BaseJoints::RequireStanding(const BasePose& start, const mjModel& model,
                                 const mjData& data) const {
  constexpr double kMostSinking = 0.02;  // m
  constexpr double kLeastUpright = 0.999;
  const double height = data.qpos[qpos_ + 2] - model.qpos0[qpos_ + 2];
  const double upright = data.xmat[9 * body_ + 8];
  if (std::abs(height) < kMostSinking && upright > kLeastUpright) return;
  throw InputError(fmt::format(
      "base.start: the mobile base cannot stand at x = {} m, y = {} m: something is in its way{}",
      start.x, start.y, NamesInTheWay(model, body_)));
}

void BaseJoints::Apply(const mjModel& model, mjData& data) noexcept {
  std::fill_n(data.qfrc_applied + dof_, 6, 0.0);
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    data.qfrc_applied[wheels_[i].dof] = drive_.tau[i];
  }
  for (Wheel& wheel : wheels_) {
    const Vector3 slip = VelocityAt(model, data, wheel.body, wheel.load.point);
    const double rolling = std::abs(data.qvel[wheel.dof]) * wheel.radius;
    const Vector3 force = wheel.tyre.Step(wheel.load, slip, rolling);
    const Vector3 torque{};
    Vector3 point = wheel.load.point;
    mju_addTo3(point.data(), data.xpos + std::ptrdiff_t{3} * wheel.body);
    mj_applyFT(&model, &data, force.data(), torque.data(), point.data(), wheel.body,
               data.qfrc_applied);
  }
}

void BaseJoints::Take(const mjModel& model, const mjData& data) noexcept {
  for (Wheel& wheel : wheels_) wheel.load = {};
  for (int i = 0; i < data.ncon; ++i) {
    const mjContact& contact = data.contact[i];
    if (contact.efc_address < 0) continue;
    const int a = model.geom_bodyid[contact.geom1];
    const int b = model.geom_bodyid[contact.geom2];
    Wheel* const wheel = Find(a) != nullptr ? Find(a) : Find(b);
    if (wheel == nullptr || model.body_weldid[wheel->body == a ? b : a] != 0) continue;
    mjtNum wrench[6];
    mj_contactForce(&model, &data, i, wrench);
    const double side = wheel->body == a ? -1 : 1;  // the normal points from geom1 to geom2
    mjtNum from_centre[3];
    mju_sub3(from_centre, contact.pos, data.xpos + std::ptrdiff_t{3} * wheel->body);
    wheel->load.force += wrench[0];
    mju_addToScl3(wheel->load.point.data(), from_centre, wrench[0]);
    mju_addToScl3(wheel->load.normal.data(), contact.frame, side * wrench[0]);
  }
  for (Wheel& wheel : wheels_) {
    const double length = mju_norm3(wheel.load.normal.data());
    if (length <= 0 || wheel.load.force <= 0) {
      wheel.load = {};
      continue;
    }
    mju_scl3(wheel.load.point.data(), wheel.load.point.data(), 1 / wheel.load.force);
    mju_scl3(wheel.load.normal.data(), wheel.load.normal.data(), 1 / length);
  }
}

void BaseJoints::Sense(const mjData& data) noexcept {
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    sensors_.q[i] = data.qpos[wheels_[i].qpos];
    sensors_.dq[i] = data.qvel[wheels_[i].dof];
  }
}

void PlaceBase(const BasePose& start, const RobotDescription& robot, mjModel& model) {
  const Link& root = robot.links.front();
  const int body = mj_name2id(&model, mjOBJ_BODY, root.name.c_str());
  const int joint = mj_name2id(&model, mjOBJ_JOINT, root.joint.c_str());
  TWIN_CHECK(body > 0 && joint >= 0);
  const std::array<mjtNum, 7> pose{
      start.x, start.y, root.X_PL.p[2], std::cos(start.yaw / 2), 0, 0, std::sin(start.yaw / 2)};
  std::copy_n(pose.begin(), 3, model.body_pos + std::ptrdiff_t{3} * body);
  std::copy_n(pose.begin() + 3, 4, model.body_quat + std::ptrdiff_t{4} * body);
  std::ranges::copy(pose, model.qpos0 + model.jnt_qposadr[joint]);
  std::ranges::copy(pose, model.qpos_spring + model.jnt_qposadr[joint]);
}

}  // namespace twin::plant
