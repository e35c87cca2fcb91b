#include "twin/replay/cell_recording.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/plant/compiled_model.h"
#include "twin/plant/shared_model.h"
#include "twin/record/log_reader.h"
#include "twin/render/frame_painter.h"
#include "twin/run/film.h"
#include "twin/run/islands.h"
#include "twin/run/result_folder.h"

namespace twin::replay {
namespace {

using Scenes = std::vector<record::SceneRecord>;

Scenes ScenesOf(const std::filesystem::path& folder) {
  const std::filesystem::path log = run::FindLog(folder);
  record::LogReader reader(log);
  Scenes scenes;
  record::LogEntry entry;
  while (reader.Next(entry)) {
    if (auto* scene = std::get_if<record::SceneRecord>(&entry)) scenes.push_back(*scene);
  }
  if (scenes.empty()) {
    throw InputError(
        fmt::format("{}: the log holds no scenes, so there is nothing to draw", log.string()));
  }
  return scenes;
}

/// A robot's scenes, and where they belong.
struct Part {
  Scenes scenes;
  std::vector<std::size_t> places;  ///< of its positions among those of all
  bool shows_forces = false;        ///< those of its island
};

/// The parts of an island, the one with the longest log last.
std::vector<Part> PartsOf(const run::Island& island, const std::filesystem::path& folder,
                          const run::RunFiles& files, const mjModel_& all) {
  std::vector<Part> parts;
  for (const scenario::CellRobot& robot : island.robots) {
    plant::MujocoPlantOptions alone = run::PlantsOf({&robot, 1}, files).front();
    alone.prefix.clear();
    const plant::CompiledModel compiled = plant::CompileModel(alone);
    Part part{.scenes = ScenesOf(folder / robot.name),
              .places = plant::PlacesOf(*compiled.model, run::PrefixOf(robot), all)};
    if (part.scenes.front().positions != part.places.size()) {
      throw InputError(fmt::format(
          "{}: its scenes have {} positions, and the model made of the scenario has {}: scene file "
          "or program are not those of the run; name them with --data",
          (folder / robot.name).string(), part.scenes.front().positions, part.places.size()));
    }
    parts.push_back(std::move(part));
  }
  std::ranges::stable_sort(parts, {}, [](const Part& part) { return part.scenes.size(); });
  parts.back().shows_forces = true;
  return parts;
}

std::shared_ptr<const mjModel_> ModelOf(const scenario::Cell& cell, const run::RunFiles& files) {
  auto model = plant::CompileArms(run::PlantsOf(cell.robots, files));
  const record::SceneRecord scene;
  const std::size_t positions = plant::InitialPositions(*model).size();
  if (positions <= scene.qpos.size()) return model;
  throw InputError(fmt::format("the scene has {} positions; a picture takes {} at most", positions,
                               scene.qpos.size()));
}

render::Snapshots SnapshotsOf(const scenario::Cell& cell, const std::filesystem::path& folder,
                              const run::RunFiles& files, const mjModel_& all) {
  std::vector<Part> parts;
  std::size_t frames = 0;
  for (const run::Island& island : run::IslandsOf(cell, files)) {
    for (Part& part : PartsOf(island, folder, files, all)) {
      frames = std::max(frames, part.scenes.size());
      parts.push_back(std::move(part));
    }
  }
  const std::vector<double> initial = plant::InitialPositions(all);
  render::Snapshots snapshots(cell.common.render.fps, initial.size());
  snapshots.Reserve(frames);
  for (std::size_t frame = 0; frame < frames; ++frame) {
    record::SceneRecord scene;
    scene.positions = static_cast<std::uint32_t>(initial.size());
    std::ranges::copy(initial, scene.qpos.begin());
    for (const Part& part : parts) {
      const bool is_over = frame >= part.scenes.size();
      const record::SceneRecord& one = is_over ? part.scenes.back() : part.scenes[frame];
      if (!is_over) scene.at = one.at;
      for (std::size_t i = 0; i < part.places.size(); ++i) {
        scene.qpos[part.places[i]] = one.qpos[i];
      }
      if (is_over || !part.shows_forces) continue;
      for (const record::PointForce& force : one.Contacts()) {
        if (scene.contacts < scene.contact.size()) scene.contact[scene.contacts++] = force;
      }
      for (const record::PointForce& push : one.Pushes()) {
        if (scene.pushes < scene.push.size()) scene.push[scene.pushes++] = push;
      }
    }
    snapshots.Append(scene);
  }
  return snapshots;
}

std::filesystem::path ScenarioIn(const std::filesystem::path& folder) {
  return run::ResultFolder(folder).scenario();
}

}  // namespace

bool IsCellFolder(const std::filesystem::path& folder) {
  std::error_code error;
  const std::filesystem::path file = ScenarioIn(folder);
  return std::filesystem::is_directory(folder, error) &&
         std::filesystem::is_regular_file(file, error) && scenario::HasRobots(file);
}

CellRecording::CellRecording(const std::filesystem::path& folder, const run::RunFiles& files)
    : cell_(scenario::LoadCell(ScenarioIn(folder))),
      model_(ModelOf(cell_, files)),
      snapshots_(SnapshotsOf(cell_, folder, files, *model_)) {}

render::Film CellRecording::Film() const {
  render::Film film;
  film.model = model_.get();
  film.snapshots = &snapshots_;
  film.title = cell_.common.name;
  return film;
}

void CheckCellPicture(const scenario::Cell& cell, const run::RunFiles& files,
                      const std::filesystem::path& file) {
  const scenario::RenderSection& wanted = cell.common.render;
  const auto model = ModelOf(cell, files);
  const render::Snapshots none(wanted.fps, plant::InitialPositions(*model).size());
  try {
    const render::FramePainter painter({.model = model.get(), .snapshots = &none},
                                       run::FilmOf(wanted));
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", file.string(), error.what()));
  }
}

}  // namespace twin::replay
