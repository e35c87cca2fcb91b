#pragma once

#include <memory>
#include <span>
#include <vector>

#include "twin/backend/registry.h"
#include "twin/plant/mujoco_plant.h"
#include "twin/run/catalogue.h"
#include "twin/scenario/cell.h"

struct mjModel_;

namespace twin::run {

/// Robots of a cell that share one model of the engine: those that can reach each other, or an
/// object that another one can reach. No robot of one island can touch what is in another, so each
/// island runs as if it were alone, to the bit.
struct Island {
  /// In the order of their names; of the scenario's objects those that are fixed, and the free ones
  /// of this island.
  std::vector<scenario::CellRobot> robots;
};

/// Divides a cell by balls around its robots (plant::ReachOf), which grow by what lies in them,
/// since a robot may carry it. A free object that no robot reaches goes with the nearest one. A
/// scene with bodies that move, and drive realtime, keep all robots together.
/// @returns islands in the order of their first robots. @throws InputError, EnvironmentError as
/// plant::MujocoPlant::Create.
[[nodiscard]] std::vector<Island> IslandsOf(const scenario::Cell& cell, const RunFiles& files);

/// What begins the names of a robot's bodies in a model of several: "left/".
[[nodiscard]] std::string PrefixOf(const scenario::CellRobot& robot);

/// The plants of some robots, for one model. @throws as MakeRobotConfig.
[[nodiscard]] std::vector<plant::MujocoPlantOptions> PlantsOf(
    std::span<const scenario::CellRobot> robots, const RunFiles& files);

/// The backend of a robot of an island with several, connected to the model they share; it must
/// outlive the backends that it makes. @param known  the program's.
[[nodiscard]] backend::Registry SeatOf(const scenario::CellRobot& robot,
                                       std::shared_ptr<plant::SharedModel> shared,
                                       const backend::Registry& known);

/// @throws InputError where an arm overlaps another, itself or an object as they start, by more
/// than a touch: names both, and where.
void RequireApartAtStart(const scenario::Cell& cell, const RunFiles& files);

}  // namespace twin::run
