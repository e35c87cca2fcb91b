#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "twin/backend/registry.h"
#include "twin/control/registry.h"
#include "twin/scenario/cell.h"
#include "twin/teleop/device_registry.h"

namespace twin::run {

/// Implementations the program offers, registered by its main. Must outlive every run.
struct Catalogue {
  const backend::Registry& backends;
  const control::ControllerRegistry& controllers;
  const teleop::DeviceRegistry* devices = nullptr;  ///< of operators; null: none
};

/// The robots of a robot's island, itself among them; default: it is alone.
struct Neighbours {
  std::span<const scenario::CellRobot> robots{};
  std::size_t own = 0;  ///< index
};

/// What a run has from outside its scenario: folders, and who stands beside its robot.
struct RunFiles {
  std::filesystem::path models;        ///< DataDirectory::models
  std::filesystem::path mesh_package;  ///< empty: primitive shapes
  std::filesystem::path cache;         ///< of compiled models; empty: none
  bool rebuild_cache = false;
  Neighbours neighbours{};  ///< that plans keep clear of
};

}  // namespace twin::run
