#pragma once

#include <filesystem>
#include <memory>

#include "twin/render/film.h"
#include "twin/render/snapshots.h"
#include "twin/run/catalogue.h"
#include "twin/scenario/cell.h"

struct mjModel_;

namespace twin::replay {

/// Whether a folder holds the results of a run of several robots.
[[nodiscard]] bool IsCellFolder(const std::filesystem::path& folder);

/// A run of several robots prepared for rendering, from the logs of its robots: all of them in one
/// picture. A robot whose run has ended before the others' stands where it was then; objects are
/// where the longest log of their island has them.
///
/// Threads: one thread; immutable after construction.
class CellRecording {
 public:
  /// @param folder  of the results.
  /// @throws InputError without a log, for a log without scenes, or scenes that do not fit the
  /// models compiled now; and as record::LogReader, scenario::LoadCell, plant::CompileArms.
  CellRecording(const std::filesystem::path& folder, const run::RunFiles& files);

  [[nodiscard]] const scenario::Cell& cell() const noexcept { return cell_; }
  [[nodiscard]] const render::Snapshots& snapshots() const noexcept { return snapshots_; }
  /// Refers to this object, which must outlive it.
  [[nodiscard]] render::Film Film() const;

 private:
  scenario::Cell cell_;
  std::shared_ptr<const mjModel_> model_;
  render::Snapshots snapshots_;
};

/// Draws one picture of a cell, before its run writes anything. @param file  the scenario's, for
/// messages. @throws InputError naming it for a camera, body or overlay the scene does not have.
void CheckCellPicture(const scenario::Cell& cell, const run::RunFiles& files,
                      const std::filesystem::path& file);

}  // namespace twin::replay
