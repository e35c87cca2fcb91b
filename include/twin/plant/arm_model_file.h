#pragma once

#include <filesystem>

#include "twin/model/arm_model.h"

namespace twin::plant {

/// The rigid-body model of an arm of the Panda's kinematics with the masses, centres of mass and
/// inertias of a URDF's links panda_link1 to panda_link7.
/// Threads: any. @throws InputError naming file and link when one is missing or has no inertial.
[[nodiscard]] model::ArmModel ArmModelOf(const std::filesystem::path& urdf);

}  // namespace twin::plant
