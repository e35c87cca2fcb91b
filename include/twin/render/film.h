#pragma once

#include <optional>
#include <string>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/render/renderer.h"
#include "twin/render/snapshots.h"
#include "twin/render/view.h"

struct mjModel_;

namespace twin::render {

/// A plan, shown during its execution: the goal of the arm, an object, or both, and the path there.
struct PlannedGoal {
  Time from{};
  Time until{};                    ///< hidden from this instant on
  std::optional<JointVector> q{};  ///< of the arm, rad; nullopt: its current position
  std::vector<Vector3> path{};  ///< path of the end effector, world, m; at most Ghost::kMostPoints
  std::string object{};         ///< free body that is moved there; empty: none
  Transform O_T_object = kIdentityTransform;
};

/// An event as text for users.
struct FilmNote {
  Time at{};
  std::string text;  ///< one line, ASCII
};

/// All drawable data of a run. Pointers must outlive the film.
struct Film {
  const mjModel_* model = nullptr;
  const Snapshots* snapshots = nullptr;
  std::string title{};                ///< case, gains: one or two lines; empty: none
  std::vector<PlannedGoal> goals{};   ///< in any order; of overlapping ones the last counts
  std::vector<FilmNote> notes{};      ///< ordered by time
  const Snapshots* before = nullptr;  ///< earlier snapshots, for the start of the trace
};

/// Overlays on a picture.
struct Overlays {
  bool text = true;       ///< time; title and events, if the film has any
  bool goal = false;      ///< planned goals
  bool trace = false;     ///< path of the end effector in the last seconds
  bool forces = false;    ///< contact forces and pushes as arrows
  bool contacts = false;  ///< contact points
  bool limits = false;    ///< each joint's position within its limits
};

/// Settings for drawing a film.
struct FilmSettings {
  RenderSettings render;  ///< size and quality; its camera is not used
  View view;
  std::vector<Inset> insets{};
  Overlays overlays;
  double trace_s = 3;       ///< length of the trace, s, > 0
  double newton_m = 0.004;  ///< length of an arrow per newton, m, > 0

  /// @throws InputError naming field, value and range; also for two insets in one corner.
  void Validate() const;
};

}  // namespace twin::render
