#pragma once

#include <filesystem>
#include <vector>

#include "twin/render/snapshots.h"
#include "twin/scenario/assembly.h"
#include "twin/scenario/scenario.h"

namespace twin::cli {

/// The pictures of a planned motion, seen by the scenario's camera: where the arm began; the same
/// with the goal as a ghost and the way of its end effector as a line; where it came to.
class PlanPictures {
 public:
  struct Paths {
    std::filesystem::path initial;
    std::filesystem::path plan;
    std::filesystem::path final;
  };

  /// Before the run: keeps where everything is. @param truth  must outlive this.
  explicit PlanPictures(const plant::TruthProbe& truth);

  /// After the run. @throws what render::FramePainter and render::WritePng throw.
  void Write(const scenario::Run& run, const scenario::Scenario& scenario, const Paths& paths);

 private:
  /// Between its two pictures, as far as it matters.
  static constexpr Duration kRunsLonger = std::chrono::seconds(1);

  const plant::TruthProbe& truth_;
  render::SnapshotRecorder recorder_;
};

}  // namespace twin::cli
