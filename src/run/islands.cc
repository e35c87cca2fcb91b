#include "twin/run/islands.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/plant/compiled_model.h"
#include "twin/plant/plant.h"
#include "twin/plant/shared_model.h"
#include "twin/run/robot_config.h"
#include "twin/scenario/objects.h"
#include "twin/scenario/robot_data.h"

namespace twin::run {
namespace {

double Distance(const Vector3& a, const Vector3& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// A set of numbers divided into groups, which only grow.
class Groups {
 public:
  explicit Groups(std::size_t size) : first_(size) {
    std::iota(first_.begin(), first_.end(), std::size_t{0});
  }
  void Join(std::size_t a, std::size_t b) {
    const auto [least, most] = std::minmax(first_[a], first_[b]);
    const std::size_t from = most;
    const std::size_t to = least;
    std::ranges::replace(first_, from, to);
  }
  /// The least number of the group.
  [[nodiscard]] std::size_t Of(std::size_t one) const { return first_[one]; }

 private:
  std::vector<std::size_t> first_;
};

/// A free object, as a ball.
struct Ball {
  std::size_t section = 0;
  Vector3 p_W{};
  double radius = 0;
};

std::vector<Ball> FreeObjects(const scenario::Scenario& scenario) {
  std::vector<Ball> balls;
  const std::vector<plant::SceneObject> objects =
      scenario::ObjectsOf(scenario.objects, scenario.seed);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const plant::SceneObject& object = objects[i];
    if (!object.mass) continue;
    const Vector3& size = object.size;
    balls.push_back({.section = i,
                     .p_W = {object.X_WB[12], object.X_WB[13], object.X_WB[14]},
                     .radius = std::hypot(size[0], size[1], size[2]) / 2});
  }
  return balls;
}

robot::RobotConfig ConfigOf(const scenario::CellRobot& robot, const RunFiles& files) {
  const scenario::Scenario& scenario = robot.scenario;
  const scenario::RobotData data = scenario::At(scenario.places.robot, scenario.robot.model, [&] {
    return scenario::LoadRobotData(files.models, scenario.robot.model, scenario.robot.hand);
  });
  return MakeRobotConfig(scenario, data, files);
}

/// Whether bodies of the scene's own file move.
bool SceneMoves(const scenario::Cell& cell, const RunFiles& files) {
  const scenario::CellRobot& robot = cell.robots.front();
  const plant::CompiledModel compiled = plant::CompileModel(ConfigOf(robot, files).plant);
  const std::size_t objects = FreeObjects(robot.scenario).size();
  return plant::JointsOf(*compiled.model) > kJoints + compiled.fingers.size() + objects;
}

/// By robot, then by free object.
Groups GroupsOf(const scenario::Cell& cell, std::vector<plant::Reach> reach,
                const std::vector<Ball>& objects) {
  const std::size_t robots = reach.size();
  Groups groups(robots + objects.size());
  const auto gap = [&](std::size_t robot, const Ball& ball) {
    return Distance(reach[robot].p_W, ball.p_W) - reach[robot].radius - ball.radius;
  };
  std::vector<double> carried(robots, 0);
  for (std::size_t k = 0; k < objects.size(); ++k) {
    std::size_t nearest = 0;
    for (std::size_t i = 0; i < robots; ++i) {
      if (gap(i, objects[k]) < gap(nearest, objects[k])) nearest = i;
      if (gap(i, objects[k]) > 0) continue;
      groups.Join(i, robots + k);
      carried[i] = std::max(carried[i], 2 * objects[k].radius);
    }
    groups.Join(nearest, robots + k);
    for (std::size_t other = 0; other < k; ++other) {
      const double apart = Distance(objects[k].p_W, objects[other].p_W);
      const auto& section = cell.robots.front().scenario.objects[objects[k].section];
      const auto& below = cell.robots.front().scenario.objects[objects[other].section];
      if (apart <= objects[k].radius + objects[other].radius || section.on == below.name) {
        groups.Join(robots + k, robots + other);
      }
    }
  }
  for (std::size_t i = 0; i < robots; ++i) reach[i].radius += carried[i];
  for (std::size_t i = 0; i < robots; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (Distance(reach[i].p_W, reach[j].p_W) <= reach[i].radius + reach[j].radius) {
        groups.Join(i, j);
      }
    }
    // What a robot carries may push what it cannot reach itself.
    for (std::size_t k = 0; k < objects.size(); ++k) {
      if (gap(i, objects[k]) <= 0) groups.Join(i, robots + k);
    }
  }
  return groups;
}

}  // namespace

std::string PrefixOf(const scenario::CellRobot& robot) {
  return robot.name + "/";
}

std::vector<plant::MujocoPlantOptions> PlantsOf(std::span<const scenario::CellRobot> robots,
                                                const RunFiles& files) {
  std::vector<plant::MujocoPlantOptions> plants;
  for (const scenario::CellRobot& robot : robots) {
    plants.push_back(ConfigOf(robot, files).plant);
    plants.back().prefix = PrefixOf(robot);
  }
  return plants;
}

backend::Registry SeatOf(const scenario::CellRobot& robot,
                         std::shared_ptr<plant::SharedModel> shared,
                         const backend::Registry& known) {
  backend::Registry seat;
  const std::string& backend = robot.scenario.backend;
  // The backend refers to its robot's configuration.
  const auto config = std::make_shared<robot::RobotConfig>();
  seat.Add(backend, [config, shared = std::move(shared), prefix = PrefixOf(robot),
                     connect = known.Find(backend)](const backend::Request& request) {
    *config = request.robot;
    config->plant.shared = shared;
    config->plant.prefix = prefix;
    config->catch_up = {};  // each step takes all robots of the model
    return connect({*config, request.time, request.sink});
  });
  return seat;
}

std::vector<Island> IslandsOf(const scenario::Cell& cell, const RunFiles& files) {
  std::vector<plant::Reach> reach;
  for (const scenario::CellRobot& robot : cell.robots) {
    reach.push_back(plant::ReachOf(ConfigOf(robot, files).plant));
  }
  const std::vector<Ball> objects = FreeObjects(cell.robots.front().scenario);
  Groups groups = GroupsOf(cell, reach, objects);
  const std::size_t robots = cell.robots.size();
  if (!cell.common.is_lockstep() || SceneMoves(cell, files)) {
    for (std::size_t i = 1; i < robots + objects.size(); ++i) groups.Join(0, i);
  }
  std::vector<Island> islands;
  for (std::size_t first = 0; first < robots; ++first) {
    if (groups.Of(first) != first) continue;
    Island& island = islands.emplace_back();
    for (std::size_t i = first; i < robots; ++i) {
      if (groups.Of(i) == first) island.robots.push_back(cell.robots[i]);
    }
    for (scenario::CellRobot& robot : island.robots) {
      std::vector<scenario::ObjectSection> here = robot.scenario.objects;
      for (std::size_t k = objects.size(); k-- > 0;) {
        if (groups.Of(robots + k) == first) continue;
        here.erase(here.begin() + static_cast<std::ptrdiff_t>(objects[k].section));
      }
      robot.scenario.objects = std::move(here);
    }
  }
  return islands;
}

void RequireApartAtStart(const scenario::Cell& cell, const RunFiles& files) {
  const std::vector<plant::MujocoPlantOptions> plants = PlantsOf(cell.robots, files);
  std::vector<JointVector> starts;
  for (const scenario::CellRobot& robot : cell.robots) {
    starts.push_back(StartOf(robot.scenario));
  }
  const auto overlap = plant::ArmsOverlap(plants, starts);
  if (!overlap || overlap->depth <= plant::Plant::kMostOverlap) return;
  const auto overlaps = [&](const scenario::CellRobot& robot) {
    const std::string prefix = PrefixOf(robot);
    return overlap->part.starts_with(prefix) || overlap->other.starts_with(prefix);
  };
  // The later of two is to give way.
  const auto whose = std::find_if(cell.robots.rbegin(), cell.robots.rend(), overlaps);
  throw InputError(fmt::format(
      "{}: robots: where they start, {} and {} overlap by {:.1f} mm; put the robots further apart "
      "(robot.pose), or let them start elsewhere (robot.q_start)",
      whose->where, overlap->part, overlap->other, 1e3 * overlap->depth));
}

}  // namespace twin::run
