#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/record/log_records.h"
#include "twin/render/film.h"
#include "twin/render/snapshots.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

struct mjModel_;

namespace twin::replay {

/// What a recording's frames come from.
enum class FrameSource : std::uint8_t {
  kScenes,  ///< from /scene: where everything really was, and what pressed on what
  kStates,  ///< from /robot/cycle: the arm by its measured q; the hand open and all else where the
            ///< scenario puts it, for nobody recorded that
};

/// A log made ready for pictures: of a simulated run, or of one on hardware; of a motion or an
/// application; whole, or of a run that was killed.
///
/// The model is compiled from the scenario in the log, as it was for the run: same robot, scene,
/// seed-drawn objects. Robots, scenes and meshes are those of `files`: what is drawn follows them.
///
/// Threads: one thread; constant after construction.
class Recording {
 public:
  /// @param least_fps  a log without scenes is sampled so often, in [0, 1000] per second of the
  /// robot's time, or as often as its scenario's video where that is more.
  /// @throws InputError when the log is damaged, tells no scenario, holds neither scenes nor
  /// cycles, or its scenes do not fit the model that is made of its scenario now; and as
  /// record::LogReader, scenario::Parse, plant::CompileModel.
  Recording(const std::filesystem::path& log, const run::RunFiles& files, int least_fps = 0);
  ~Recording();
  Recording(Recording&&) noexcept;
  Recording& operator=(Recording&&) = delete;

  [[nodiscard]] const record::RunInfo& run() const noexcept;
  [[nodiscard]] const scenario::Scenario& scenario() const noexcept;
  [[nodiscard]] FrameSource source() const noexcept;
  /// Whether the run was killed before the log was finished: there are no plans then.
  [[nodiscard]] bool truncated() const noexcept;

  [[nodiscard]] const mjModel_& model() const noexcept;
  /// In order of time; at least one. Their rate is that of the scenario's video, or the one that
  /// was asked for.
  [[nodiscard]] const render::Snapshots& snapshots() const noexcept;
  /// Where the arm is in positions of the model, rad. @pre of the model's size.
  [[nodiscard]] JointVector ArmIn(std::span<const double> qpos) const;
  /// Where its end effector is in a snapshot, as the robot was told of it; world, m.
  /// @pre frame < snapshots().size()
  [[nodiscard]] Vector3 ToolAt(std::size_t frame) const;
  [[nodiscard]] const std::vector<record::PlanRecord>& plans() const noexcept;
  [[nodiscard]] const std::vector<record::EventRecord>& events() const noexcept;

  /// As FilmOfRun(). Refers to this, which must outlive it.
  [[nodiscard]] render::Film Film() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::replay
