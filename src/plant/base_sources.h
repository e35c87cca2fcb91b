#pragma once

#include <filesystem>

#include "plant/file_bytes.h"
#include "plant/robot_description.h"

namespace twin::plant {

/// Reads and hashes a mobile base's URDF, with primitive shapes only. Its root gets a free joint,
/// at the height above the floor that its wheels define.
/// @throws InputError naming file and element if it violates BaseOptions.
[[nodiscard]] RobotDescription ReadBase(const std::filesystem::path& urdf, ContentHash& hash);

}  // namespace twin::plant
