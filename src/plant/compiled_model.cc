#include "twin/plant/compiled_model.h"

#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include "plant/model_loader.h"
#include "twin/core/error.h"
#include "twin/plant/engine.h"

namespace twin::plant {

CompiledModel CompileModel(const MujocoPlantOptions& options) {
  PrepareEngine();
  try {
    const ModelSources sources = ReadModelSources(options);
    BuiltModel built = LoadOrBuild(options, sources);
    CompiledModel compiled;
    std::size_t i = 0;
    for (const Link& link : sources.robot.links) {
      if (link.joint_kind == JointKind::kFixed) continue;
      const int joint = mj_name2id(built.model.get(), mjOBJ_JOINT, link.joint.c_str());
      if (link.joint_kind == JointKind::kRevolute) {
        compiled.arm[i++] = joint;
      } else {
        compiled.fingers.push_back(joint);
        compiled.open = link.q_max;
      }
    }
    compiled.model = std::move(built.model);
    return compiled;
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

}  // namespace twin::plant
