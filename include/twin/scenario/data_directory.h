#pragma once

#include <filesystem>
#include <vector>

namespace twin::scenario {

/// Where to look for the twin's data.
struct DataSearch {
  std::filesystem::path executable;  ///< the running program
  std::filesystem::path models;      ///< given by the user; empty: sought
  std::filesystem::path meshes;      ///< given by the user; empty: sought
};

/// Folders of the twin's data.
struct DataDirectory {
  std::filesystem::path models;                        ///< robots, scenes, scenarios
  std::filesystem::path mesh_package;                  ///< panda_description; empty: not there
  std::vector<std::filesystem::path> mesh_candidates;  ///< where the meshes were sought
};

/// Finds the data beside the program, wherever it was put:
///   models   as given; else <program>/../share/panda_twin/models (installed); else
///            <program>/../../models (a build folder two levels below the source tree)
///   meshes   as given; else share/panda_twin/panda_description; else .data/panda_description of
///            the source tree. They may be missing: the arm is then drawn in primitive shapes.
/// A folder of models has a folder `robots`; a mesh package has a folder `meshes`.
/// @throws InputError when a folder that was given is none; EnvironmentError when no models are
/// found. Both say where was looked and what to do.
[[nodiscard]] DataDirectory FindDataDirectory(const DataSearch& search);

/// The scenario file that a user names: as given, else below the models folder, where
/// "scenarios/grasp.yaml" and "models/scenarios/grasp.yaml" are the same. @returns `named` when
/// there is neither. @throws InputError for "grasp.yaml" alone: it says the folder to add.
[[nodiscard]] std::filesystem::path FindScenario(const std::filesystem::path& named,
                                                 const std::filesystem::path& models);

}  // namespace twin::scenario
