#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/record/log_records.h"
#include "twin/render/clip.h"
#include "twin/render/film.h"
#include "twin/render/snapshots.h"
#include "twin/run/console.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

struct mjModel_;

namespace twin::replay {

/// All drawable data of a run, from its end or from a log. Both give the same, so that a video can
/// be made again.
///
///   title  the scenario's name; below it the controller's gains or the application's type
///   goals  the plans
///   notes  the captions of starting plans, and the events that matter to users: steps, the hand,
///          errors, stops, recoveries. One line of at most 48 characters each, ASCII.
///
/// Threads: any. @param model, snapshots  must outlive the film.
[[nodiscard]] render::Film FilmOfRun(const mjModel_& model, const render::Snapshots& snapshots,
                                     const scenario::Scenario& scenario,
                                     std::span<const record::PlanRecord> plans,
                                     std::span<const record::EventRecord> events);

/// Draws one picture, before a run writes anything.
/// @pre connection.truth is not null.
/// @param scenario  its file, for messages.
/// @throws InputError naming it for a camera or body the scene does not have; EnvironmentError
/// without OSMesa.
void CheckPicture(const backend::Connection& connection, const scenario::RenderSection& wanted,
                  const std::filesystem::path& scenario);

/// Renders frames as a video, and a contact sheet of them, on one thread for each processor, and
/// shows the progress. @returns counts and times. @throws as render::RenderClip; run::Interrupted.
render::ClipStats RenderClip(const render::ClipFrames& frames, const render::ClipPaths& paths,
                             const Clock& clock, run::Console& console);

}  // namespace twin::replay

struct mjModel_;

namespace twin::replay {

/// Source of a recording's frames.
enum class FrameSource : std::uint8_t {
  kScenes,  ///< from /scene: the true positions and contact forces
  kStates,  ///< from /robot/cycle: the arm by its measured q; the hand open and all else at its
            ///< initial pose, because no record has them
};

/// A log prepared for rendering: of a simulated run or one on hardware, of a motion or an
/// application, complete or of a killed run.
///
/// The model is compiled from the scenario in the log, as for the run: same robot, scene and random
/// objects. Robots, scenes and meshes come from `files`: pictures follow their changes.
///
/// Threads: one thread; immutable after construction.
class Recording {
 public:
  /// @param least_fps  sampling rate of a log without scenes, in [0, 1000] per second of robot
  /// time; the rate of its scenario's video counts if higher.
  /// @throws InputError if the log is damaged, has no scenario, has neither scenes nor cycles, or
  /// its scenes do not fit the model compiled now; and as record::LogReader, scenario::Parse,
  /// plant::CompileModel.
  Recording(const std::filesystem::path& log, const run::RunFiles& files, int least_fps = 0);
  ~Recording();
  Recording(Recording&&) noexcept;
  Recording& operator=(Recording&&) = delete;

  [[nodiscard]] const record::RunInfo& run() const noexcept;
  [[nodiscard]] const scenario::Scenario& scenario() const noexcept;
  [[nodiscard]] FrameSource source() const noexcept;
  /// True if the run was killed before the log was finished; it then has no plans.
  [[nodiscard]] bool truncated() const noexcept;

  [[nodiscard]] const mjModel_& model() const noexcept;
  /// Ordered by time; at least one. Their rate is that of the scenario's video, or the requested
  /// one.
  [[nodiscard]] const render::Snapshots& snapshots() const noexcept;
  /// The arm's joints in the model's positions, rad. @pre of the model's size.
  [[nodiscard]] JointVector ArmIn(std::span<const double> qpos) const;
  /// Position of the end effector in a snapshot, by the robot's EE frame; world, m.
  /// @pre frame < snapshots().size()
  [[nodiscard]] Vector3 ToolAt(std::size_t frame) const;
  [[nodiscard]] const std::vector<record::PlanRecord>& plans() const noexcept;
  [[nodiscard]] const std::vector<record::EventRecord>& events() const noexcept;

  /// As FilmOfRun(); of a served robot's log the title names no controller, because none of the
  /// scenario's ran. Refers to this object, which must outlive it.
  [[nodiscard]] render::Film Film() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::replay
