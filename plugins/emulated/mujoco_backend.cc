#include "plugins/backends.h"

#include <utility>
#include <variant>

#include "plugins/emulated/emulated_backend.h"
#include "twin/core/error.h"
#include "twin/robot/robot_config.h"

namespace twin::plugins {
namespace {

/// Makes the plant and sets its data in the connection.
NamedPlant MakePlant(const robot::RobotConfig& robot, backend::Connection& connection) {
  robot::MadePlant made = robot::MakePlant(robot);
  if (const plant::MujocoPlant* engine = made.engine) {
    connection.truth = engine;
    connection.engine_warnings = [engine] { return engine->DescribeWarnings(); };
    connection.uses_meshes = engine->uses_meshes();
  }
  return {std::move(made.plant), std::move(made.name)};
}

backend::Connection Connect(const backend::Request& request) {
  if (std::holds_alternative<backend::RemoteRobot>(request.time)) {
    throw InputError(
        "backend mujoco is in this process, not at the other end of a wire; say drive: lockstep or "
        "realtime, or backend: fci");
  }
  backend::Connection connection;
  NamedPlant plant = MakePlant(request.robot, connection);
  if (const auto* lockstep = std::get_if<backend::VirtualTime>(&request.time)) {
    ConnectLockstep(request, *lockstep, std::move(plant), connection);
  } else {
    ConnectRealtime(request, std::get<backend::WallTime>(request.time), std::move(plant),
                    connection);
  }
  return connection;
}

}  // namespace

void RegisterMujoco(backend::Registry& registry) {
  registry.Add("mujoco", &Connect);
}

}  // namespace twin::plugins
