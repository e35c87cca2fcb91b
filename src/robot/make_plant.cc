#include "twin/robot/make_plant.h"

#include <utility>

#include "twin/model/payload.h"
#include "twin/plant/ideal_plant.h"

namespace twin::robot {

MadePlant MakePlant(const RobotConfig& config) {
  if (config.plant_kind == PlantKind::kIdeal) {
    const setting::Load& load = config.plant.load;
    const model::Payload there =
        model::Combine(config.onboard.end_effector, {load.m_load, load.F_x_Cload, load.I_load});
    return {std::make_unique<plant::IdealPlant>(there, config.plant.hand), nullptr,
            "ideal plant (q = q_d)"};
  }
  std::unique_ptr<plant::MujocoPlant> plant = plant::MujocoPlant::Create(config.plant);
  plant::MujocoPlant* engine = plant.get();
  return {std::move(plant), engine, "MuJoCo plant"};
}

}  // namespace twin::robot
