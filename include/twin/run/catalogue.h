#pragma once

#include <filesystem>

#include "twin/backend/registry.h"
#include "twin/control/registry.h"
#include "twin/teleop/device_registry.h"

namespace twin::run {

/// Implementations the program offers, registered by its main. Must outlive every run.
struct Catalogue {
  const backend::Registry& backends;
  const control::ControllerRegistry& controllers;
  const teleop::DeviceRegistry* devices = nullptr;  ///< of operators; null: none
};

/// Folders from which a run reads its files.
struct RunFiles {
  std::filesystem::path models;        ///< DataDirectory::models
  std::filesystem::path mesh_package;  ///< empty: primitive shapes
  std::filesystem::path cache;         ///< of compiled models; empty: none
  bool rebuild_cache = false;
};

}  // namespace twin::run
