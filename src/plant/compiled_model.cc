#include "twin/plant/compiled_model.h"

#include <cmath>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include "plant/model_builder.h"
#include "twin/core/error.h"
#include "twin/plant/engine.h"

namespace twin::plant {
namespace {

/// The joints of an arm and its hand, without the model.
CompiledModel ArmJointsOf(const RobotDescription& robot, const mjModel& model) {
  CompiledModel compiled;
  std::size_t i = 0;
  for (const Link& link : robot.links) {
    if (!HasRange(link.joint_kind)) continue;
    const int joint = mj_name2id(&model, mjOBJ_JOINT, link.joint.c_str());
    if (link.joint_kind == JointKind::kRevolute) {
      compiled.arm[i++] = joint;
    } else {
      compiled.fingers.push_back(joint);
      compiled.open = link.q_max;
    }
  }
  return compiled;
}

}  // namespace

CompiledModel CompileModel(const MujocoPlantOptions& options) {
  return CompileModels({&options, 1}).front();
}

std::vector<CompiledModel> CompileModels(std::span<const MujocoPlantOptions> arms) {
  PrepareEngine();
  try {
    const ModelSources sources = ReadModelSources(arms);
    const std::shared_ptr<const mjModel> model = LoadOrBuild(arms.front(), sources).model;
    std::vector<CompiledModel> all;
    for (std::size_t i = 0; i < arms.size(); ++i) {
      const RobotDescription& robot = sources.arms[i].robot;
      CompiledModel& compiled = all.emplace_back(ArmJointsOf(robot, *model));
      if (arms[i].base) {
        compiled.base = mj_name2id(model.get(), mjOBJ_JOINT, robot.links.front().joint.c_str());
      }
      compiled.model = model;
    }
    return all;
  } catch (const EngineFault& fault) {
    throw EnvironmentError(
        fmt::format("the engine failed while it set up the model: {}", fault.what()));
  }
}

std::vector<double> PositionsAt(const CompiledModel& compiled, const JointVector& q) {
  const mjModel& model = *compiled.model;
  std::vector<double> qpos(model.qpos0, model.qpos0 + model.nq);
  const auto put = [&](int joint, double value) {
    qpos[static_cast<std::size_t>(model.jnt_qposadr[joint])] = value;
  };
  for (std::size_t i = 0; i < kJoints; ++i) put(compiled.arm[i], q[i]);
  for (const int finger : compiled.fingers) put(finger, compiled.open);
  return qpos;
}

JointVector ArmIn(const CompiledModel& compiled, std::span<const double> qpos) {
  JointVector q{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    q[i] = qpos[static_cast<std::size_t>(compiled.model->jnt_qposadr[compiled.arm[i]])];
  }
  return q;
}

Transform ArmBaseIn(const CompiledModel& compiled, std::span<const double> qpos) {
  const mjModel& model = *compiled.model;
  // All links from link 0 down to the world, or to the body with the free joint, are fixed.
  const int root = compiled.base < 0 ? -1 : model.jnt_bodyid[compiled.base];
  std::array<mjtNum, 3> p{};
  std::array<mjtNum, 4> turn{1, 0, 0, 0};
  int body = model.body_parentid[model.jnt_bodyid[compiled.arm.front()]];
  while (body > 0) {
    const mjtNum* const free =
        body == root ? qpos.data() + model.jnt_qposadr[compiled.base] : nullptr;
    const mjtNum* const p_body = free != nullptr ? free : model.body_pos + std::ptrdiff_t{3} * body;
    const mjtNum* const turn_body =
        free != nullptr ? free + 3 : model.body_quat + std::ptrdiff_t{4} * body;
    mjtNum turned[3];
    mju_rotVecQuat(turned, p.data(), turn_body);
    mju_add3(p.data(), p_body, turned);
    mjtNum product[4];
    mju_mulQuat(product, turn_body, turn.data());
    mju_copy4(turn.data(), product);
    if (body == root) break;
    body = model.body_parentid[body];
  }
  std::array<mjtNum, 9> R{};
  mju_quat2Mat(R.data(), turn.data());
  return {R[0], R[3], R[6], 0, R[1], R[4], R[7], 0, R[2], R[5], R[8], 0, p[0], p[1], p[2], 1};
}

void MoveBase(const CompiledModel& compiled, const BasePose& from_start, std::span<double> qpos) {
  if (compiled.base < 0) return;
  const auto at = static_cast<std::size_t>(compiled.model->jnt_qposadr[compiled.base]);
  const double yaw = 2 * std::atan2(qpos[at + 6], qpos[at + 3]);
  qpos[at] += std::cos(yaw) * from_start.x - std::sin(yaw) * from_start.y;
  qpos[at + 1] += std::sin(yaw) * from_start.x + std::cos(yaw) * from_start.y;
  qpos[at + 3] = std::cos((yaw + from_start.yaw) / 2);
  qpos[at + 6] = std::sin((yaw + from_start.yaw) / 2);
}

}  // namespace twin::plant
