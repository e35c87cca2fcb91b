#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace twin::scenario {

/// What a folder below models/robots describes.
enum class RobotKind : std::uint8_t { kArm, kHand, kBase };

/// "arm", "hand", "base".
[[nodiscard]] std::string_view Name(RobotKind kind) noexcept;

/// Where some figures of a robot come from.
struct FigureSource {
  std::string figures;  ///< which
  std::string source;   ///< document, version and licence; or that they are this project's
};

/// A robot's robot.yaml: what it is, and the sources of all its figures.
///
/// A robot of the Panda's kinematics is added as a folder: robot.yaml, NAME.urdf, limits.yaml and
/// drives.yaml, and primitives.yaml if it shall be seen without meshes.
struct RobotIdentity {
  std::string name;   ///< of the folder
  std::string title;  ///< for people
  RobotKind kind{};
  std::uint16_t protocol = 0;  ///< of the Franka Control Interface, 5 or 10; 0: no arm
  /// Whether INT's rigid-body model is that of the Panda's model library; else it has the masses
  /// and inertias of the URDF.
  bool has_library_model = false;
  std::vector<FigureSource> sources;
};

/// @param models  the models folder. @param name  folder below models/robots.
/// @throws InputError for an unknown robot (lists the known ones), and for a wrong robot.yaml
/// (names file, line and key).
[[nodiscard]] RobotIdentity LoadRobotIdentity(const std::filesystem::path& models,
                                              std::string_view name);

/// All robots, by name. @throws as LoadRobotIdentity.
[[nodiscard]] std::vector<RobotIdentity> ListRobots(const std::filesystem::path& models);

}  // namespace twin::scenario
