#pragma once

#include <filesystem>

#include "plant/file_bytes.h"
#include "plant/robot_description.h"

namespace twin::plant {

/// Reads a mobile base's URDF, its shapes all primitive, and hashes it. Its root comes back with a
/// free joint, as high above the floor as its wheels hold it.
/// @throws InputError naming file and element for anything that is no such base; see BaseOptions.
[[nodiscard]] RobotDescription ReadBase(const std::filesystem::path& urdf, ContentHash& hash);

}  // namespace twin::plant
