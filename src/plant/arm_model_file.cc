#include "twin/plant/arm_model_file.h"

#include <array>
#include <cstddef>

#include <fmt/format.h>

#include "plant/file_bytes.h"
#include "plant/robot_description.h"
#include "twin/core/error.h"

namespace twin::plant {

model::ArmModel ArmModelOf(const std::filesystem::path& urdf) {
  const RobotDescription robot = ParseUrdf(ReadFileBytes(urdf, "the robot's URDF"), urdf.string());
  std::array<model::LinkParameters, kJoints> links;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const std::string name = fmt::format("panda_link{}", i + 1);
    const Link* const link = robot.Find(name);
    if (link == nullptr || !link->inertial) {
      throw InputError(fmt::format("{}: {} {}; an arm needs mass and inertia of its seven links",
                                   urdf.string(), link == nullptr ? "no link" : "no inertial of",
                                   name));
    }
    const Matrix3& I = link->inertial->I;
    links[i] = {link->inertial->mass, link->inertial->com, {I[0], I[1], I[2], I[4], I[5], I[8]}};
  }
  return model::ArmModel(links);
}

}  // namespace twin::plant
