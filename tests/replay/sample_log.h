#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "twin/plant/compiled_model.h"
#include "twin/record/recorder.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

namespace twin::replay::test {

/// The models that come with the program; the robot in primitive shapes.
inline run::RunFiles Files() {
  return {
      .models = std::filesystem::path(TWIN_SOURCE_DIR) / "models", .mesh_package = {}, .cache = {}};
}

/// A scenario with a ball beside the robot, whose size and place the seed draws.
inline scenario::Scenario Sample() {
  scenario::Scenario scenario =
      scenario::Load(std::filesystem::path(TWIN_SOURCE_DIR) / "models/scenarios/smoke.yaml");
  scenario.seed = 7;
  scenario::ObjectSection ball{.name = "ball", .shape = plant::ObjectShape::kSphere};
  ball.size = {0.05, 0.05, 0.05};
  ball.mass = 0.2;
  ball.pose.position = {0.5, 0.2, 0.4};
  ball.spread.position = {0.05, 0.05, 0.05};
  scenario.objects.push_back(ball);
  return scenario;
}

inline record::RunInfo InfoOf(const scenario::Scenario& scenario) {
  return {.scenario = scenario.name,
          .seed = scenario.seed,
          .version = "test",
          .drive = "lockstep",
          .scenario_yaml = scenario::ToYaml(scenario)};
}

/// The model of a scenario, made apart from what is tested.
inline plant::CompiledModel ModelOf(const scenario::Scenario& scenario) {
  const scenario::RobotData robot =
      scenario::LoadRobotData(Files().models, scenario.robot.model, scenario.robot.hand);
  return plant::CompileModel(run::MakeRobotConfig(scenario, robot, Files()).plant);
}

/// Where the sample arm is: a motion of all joints that no two instants share.
inline JointVector ArmAt(Time at) {
  const double t = ToSeconds(at.time_since_epoch());
  return {0.1 * t, -0.5, 0.05 * t, -2 + 0.1 * t, 0, 1.5, 0.7};
}

/// The cycle of the sample arm at k milliseconds.
inline record::CycleRecord CycleAt(std::uint64_t k) {
  record::CycleRecord cycle;
  cycle.at = Time(static_cast<std::int64_t>(k) * kCycle);
  cycle.state.message_id = k + 1;
  cycle.state.q = ArmAt(cycle.at);
  return cycle;
}

/// The scene of the sample arm; nothing else moves.
inline record::SceneRecord SceneAt(Time at, const plant::CompiledModel& model) {
  record::SceneRecord scene;
  scene.at = at;
  const std::vector<double> qpos = plant::PositionsAt(model, ArmAt(at));
  scene.positions = static_cast<std::uint32_t>(qpos.size());
  std::copy(qpos.begin(), qpos.end(), scene.qpos.begin());
  return scene;
}

}  // namespace twin::replay::test
