#include "plugins/mujoco/mujoco_backend.h"

#include <memory>
#include <utility>
#include <variant>

#include "plugins/mujoco/emulated_backend.h"
#include "plugins/mujoco/lockstep_backend.h"
#include "plugins/mujoco/realtime_backend.h"
#include "twin/core/error.h"
#include "twin/model/payload.h"
#include "twin/plant/ideal_plant.h"
#include "twin/plant/mujoco_plant.h"

namespace twin::plugins {
namespace {

/// What really hangs on the flange, whatever INT is told of it.
model::Payload WhatIsThere(const robot::RobotConfig& robot) {
  const setting::Load& load = robot.plant.load;
  return model::Combine(robot.onboard.end_effector, {load.m_load, load.F_x_Cload, load.I_load});
}

/// Makes the body, and fills in what the connection tells of it.
NamedPlant MakePlant(const robot::RobotConfig& robot, backend::Connection& connection) {
  if (robot.plant_kind == robot::PlantKind::kIdeal) {
    return {std::make_unique<plant::IdealPlant>(WhatIsThere(robot), robot.plant.hand),
            "ideal plant (q = q_d)"};
  }
  auto plant = plant::MujocoPlant::Create(robot.plant);
  connection.truth = plant.get();
  connection.engine_warnings = [source = plant.get()] { return source->DescribeWarnings(); };
  connection.uses_meshes = plant->uses_meshes();
  return {std::move(plant), "MuJoCo plant"};
}

backend::Connection Connect(const backend::Request& request) {
  if (std::holds_alternative<backend::RemoteHost>(request.host)) {
    throw InputError(
        "backend mujoco is in this process, not at the other end of a wire; say drive: lockstep or "
        "realtime, or backend: fci");
  }
  backend::Connection connection;
  NamedPlant plant = MakePlant(request.robot, connection);
  if (const auto* lockstep = std::get_if<backend::LockstepHost>(&request.host)) {
    ConnectLockstep(request, *lockstep, std::move(plant), connection);
  } else {
    ConnectRealtime(request, std::get<backend::RealtimeHost>(request.host), std::move(plant),
                    connection);
  }
  return connection;
}

}  // namespace

void RegisterMujoco(backend::Registry& registry) {
  registry.Add("mujoco", &Connect);
}

}  // namespace twin::plugins
