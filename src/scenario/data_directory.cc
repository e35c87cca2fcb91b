#include "twin/scenario/data_directory.h"

#include <string_view>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::scenario {
namespace {

namespace fs = std::filesystem;

bool HasFolder(const fs::path& folder, std::string_view child) {
  std::error_code error;
  return fs::is_directory(folder / child, error);
}

/// @returns the first candidate that has a folder `child`; empty when none has.
fs::path FirstWith(const std::vector<fs::path>& candidates, std::string_view child) {
  for (const fs::path& candidate : candidates) {
    if (HasFolder(candidate, child)) return candidate;
  }
  return {};
}

std::string List(const std::vector<fs::path>& paths) {
  std::string list;
  for (const fs::path& path : paths) list += (list.empty() ? "" : ", ") + path.string();
  return list;
}

}  // namespace

DataDirectory FindDataDirectory(const DataSearch& search) {
  const fs::path installed =
      (search.executable.parent_path() / ".." / "share" / "panda_twin").lexically_normal();
  const fs::path source_tree = (search.executable.parent_path() / ".." / "..").lexically_normal();
  DataDirectory data;

  std::vector<fs::path> candidates{installed / "models", source_tree / "models"};
  if (!search.models.empty()) candidates = {search.models};
  data.models = FirstWith(candidates, "robots");
  if (data.models.empty() && !search.models.empty()) {
    throw InputError(
        fmt::format("--data {}: has no folder robots; give the folder models of the "
                    "twin",
                    search.models.string()));
  }
  if (data.models.empty()) {
    throw EnvironmentError(
        fmt::format("the twin's models were not found; looked in {}; name the folder with --data",
                    List(candidates)));
  }

  data.mesh_candidates = {installed / "panda_description",
                          source_tree / ".data" / "panda_description"};
  if (!search.meshes.empty()) data.mesh_candidates = {search.meshes};
  data.mesh_package = FirstWith(data.mesh_candidates, "meshes");
  if (data.mesh_package.empty() && !search.meshes.empty()) {
    throw InputError(fmt::format(
        "--meshes {}: has no folder meshes; give the folder panda_description of the package "
        "example-robot-data",
        search.meshes.string()));
  }
  return data;
}

fs::path FindScenario(const fs::path& named, const fs::path& models) {
  std::error_code none;
  if (named.is_absolute() || fs::exists(named, none)) return named;
  const bool says_models = !named.empty() && *named.begin() == "models";
  fs::path installed = models / (says_models ? named.lexically_relative("models") : named);
  if (fs::is_regular_file(installed, none)) return installed;
  if (!named.has_parent_path() && fs::is_regular_file(models / "scenarios" / named, none)) {
    throw InputError(fmt::format(
        "{0}: no such file here; name one of the installed with its folder: scenarios/{0}",
        named.native()));
  }
  return named;
}

}  // namespace twin::scenario
