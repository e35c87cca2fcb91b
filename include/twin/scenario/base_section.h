#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "twin/core/mobile_base.h"
#include "twin/core/time.h"
#include "twin/onboard/base_controller.h"

namespace twin::scenario {

/// A velocity that a mobile base is asked for, for a while.
struct DriveEvent {
  Duration at{};    ///< since the run began
  Duration span{};  ///< > 0
  BaseTwist twist;  ///< what exceeds the base's limits is saturated
  bool operator==(const DriveEvent&) const = default;
};

/// The mobile base that carries the arm. With it the world's frame lies on the floor.
struct BaseSection {
  std::string model = "husky";  ///< folder below models/robots
  BasePose start;               ///< on the floor, m and rad
  /// What it is asked for, one after the other; zero in between. None beside an application.
  std::vector<DriveEvent> drive;

  /// @throws InputError naming field and value.
  void Validate() const;
  bool operator==(const BaseSection&) const = default;
};

/// What is known of a mobile base, read from its folder below models/robots.
struct BaseData {
  std::filesystem::path urdf;  ///< <name>/<name>.urdf
  onboard::BaseConfig config;  ///< from <name>/base.yaml
};

/// @param models  the models folder. @param name  folder below models/robots.
/// @throws InputError when there is no such base (names those there are), or naming file, line and
/// key of what is wrong in its data.
[[nodiscard]] BaseData LoadBaseData(const std::filesystem::path& models, std::string_view name);

}  // namespace twin::scenario
