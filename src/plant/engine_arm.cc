#include "plant/engine_arm.h"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "plant/joint_parameters.h"

namespace twin::plant {

EngineArm::Joints EngineArm::FindJoints(const mjModel& model, const RobotDescription& robot) {
  Joints found;
  std::size_t i = 0;
  for (const Link& link : robot.links) {
    if (link.joint_kind == JointKind::kFixed) continue;
    const int joint = mj_name2id(&model, mjOBJ_JOINT, link.joint.c_str());
    found.all.push_back(joint);
    if (link.joint_kind != JointKind::kRevolute) continue;
    found.qpos[i] = model.jnt_qposadr[joint];
    found.dof[i] = model.jnt_dofadr[joint];
    found.tau_max[i] = link.tau_max;
    ++i;
  }
  return found;
}

EngineArm::EngineArm(const MujocoPlantOptions& options, const RobotDescription& robot,
                     const mjModel& model)
    : friction_(options.friction),
      friction_law_(options.arm.friction_law),
      noise_(options.noise),
      random_(options.seed, RandomStream::kSensorNoise),
      joints_(FindJoints(model, robot)),
      elasticity_(options.elasticity),
      stiffness_(options.arm.stiffness),
      live_{.perturber = Perturber(model, options.prefix),
            .brakes = Brakes(model, joints_.dof, joints_.tau_max),
            .tau_J_late = TorqueDelay(options.arm.torque_delay)} {
  for (const Perturbation& perturbation : options.perturbations) live_.perturber.Add(perturbation);
  for (std::size_t i = 0; i < kJoints; ++i) armature_[i] = model.dof_armature[joints_.dof[i]];
  if (options.hand == HandKind::kFrankaHand) live_.hand.emplace(model, robot);
  if (options.hand == HandKind::kCobotPump) live_.suction.emplace(model, robot);
  if (options.base) live_.base.emplace(model, robot);
}

void EngineArm::SetJoints(const JointVector& q, mjData& data) const noexcept {
  for (std::size_t i = 0; i < kJoints; ++i) data.qpos[joints_.qpos[i]] = q[i];
}

JointVector EngineArm::BiasIn(const mjData& data) const noexcept {
  JointVector bias{};
  for (std::size_t i = 0; i < kJoints; ++i) bias[i] = data.qfrc_bias[joints_.dof[i]];
  return bias;
}

bool EngineArm::Has(int joint) const noexcept {
  return std::ranges::find(joints_.all, joint) != joints_.all.end();
}

void EngineArm::Reset(const JointVector& q, mjModel& model, mjData& data) {
  // Of use where only this arm begins anew.
  for (const int joint : joints_.all) {
    if (model.jnt_type[joint] == mjJNT_FREE) continue;
    data.qvel[model.jnt_dofadr[joint]] = 0;
    data.qacc_warmstart[model.jnt_dofadr[joint]] = 0;
  }
  SetJoints(q, data);
  if (live_.hand) live_.hand->Reset(data);
  if (live_.suction) live_.suction->Reset();
  live_.perturber.Restart();
  live_.brakes.Reset(model);
  live_.drive = {};
}

void EngineArm::SenseAtRest(const mjData& data) noexcept {
  // At rest the brakes or the controller carry the arm's weight, which the torque sensors show.
  const JointVector tau_J = BiasIn(data);
  live_.tau_J = tau_J;
  live_.tau_J_late.Fill(tau_J);
  SenseJoints(tau_J, data, 0);
  if (live_.base) live_.base->Sense(data);
}

JointVector EngineArm::FrictionAt(const JointVector& dq) const noexcept {
  if (friction_law_) return Friction(*friction_law_, dq);
  return friction_ == FrictionProfile::kResidual ? ResidualFriction(dq) : JointVector{};
}

void EngineArm::Apply(Duration begin, const mjModel& model, mjData& data) noexcept {
  JointVector dq{};
  for (std::size_t i = 0; i < kJoints; ++i) dq[i] = data.qvel[joints_.dof[i]];
  friction_now_ = FrictionAt(dq);
  live_.perturber.Apply(begin, data);
  if (live_.suction) live_.suction->Apply(model, data);
  if (live_.hand) live_.hand->Apply(data);
  if (live_.base) live_.base->Apply(model, data);
}

void EngineArm::Drive(mjModel& model, mjData& data) {
  live_.brakes.Set(live_.drive.brakes, model, data);
  for (std::size_t i = 0; i < kJoints; ++i) {
    data.qfrc_applied[joints_.dof[i]] =
        live_.drive.tau[i] + live_.brakes.carried()[i] - friction_now_[i];
  }
}

void EngineArm::Take(const mjModel& model, const mjData& data) {
  const JointVector tau_brake = live_.brakes.Take(data);
  if (live_.base) live_.base->Take(model, data);
  for (std::size_t i = 0; i < kJoints; ++i) {
    tau_J_now_[i] = live_.drive.tau[i] + tau_brake[i] - armature_[i] * data.qacc[joints_.dof[i]];
  }
}

void EngineArm::Sense(const mjData& data, std::uint64_t tick) noexcept {
  SenseJoints(tau_J_now_, data, tick);
  if (live_.hand) live_.hand->Sense(data);
  if (live_.base) live_.base->Sense(data);
}

void EngineArm::Lose() noexcept {
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  for (JointVector* values : {&live_.sensors.q, &live_.sensors.dq, &live_.sensors.tau_J,
                              &live_.sensors.theta, &live_.sensors.dtheta}) {
    values->fill(kNothing);
  }
}

void EngineArm::SenseJoints(const JointVector& tau_J, const mjData& data,
                            std::uint64_t tick) noexcept {
  JointSensors& sensors = live_.sensors;
  sensors.tau_J = live_.tau_J_late.Pass(tau_J);
  for (std::size_t i = 0; i < kJoints; ++i) {
    sensors.q[i] = data.qpos[joints_.qpos[i]];
    sensors.dq[i] = data.qvel[joints_.dof[i]];
  }
  const auto add = [this, tick](double deviation, std::uint32_t first_draw, JointVector& values) {
    if (deviation == 0) return;
    for (std::uint32_t i = 0; i < kJoints; ++i) {
      values[i] += deviation * random_.Normal(tick, first_draw + i);
    }
  };
  add(noise_.q_rad, 0, sensors.q);
  add(noise_.dq_rad_per_s, kJoints, sensors.dq);
  add(noise_.tau_J_Nm, 2 * kJoints, sensors.tau_J);
  sensors.theta = sensors.q;
  sensors.dtheta = sensors.dq;
  if (elasticity_ == ElasticityProfile::kStatic) {
    for (std::size_t i = 0; i < kJoints; ++i) {
      sensors.theta[i] += tau_J[i] / stiffness_[i];
      sensors.dtheta[i] += (tau_J[i] - live_.tau_J[i]) / (kCycleSeconds * stiffness_[i]);
    }
  }
  live_.tau_J = tau_J;
}

}  // namespace twin::plant
