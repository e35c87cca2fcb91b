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

/// What was planned, shown while it is carried out: the arm, an object, or both where they should
/// come to, and the way there.
struct PlannedGoal {
  Time from{};
  Time until{};                    ///< not shown any more at this instant
  std::optional<JointVector> q{};  ///< of the arm, rad; absent: where it is
  std::vector<Vector3> way{};      ///< of the end effector, world, m; at most Ghost::kMostPoints
  std::string object{};            ///< free body that is carried there; empty: none
  Transform O_T_object = kIdentityTransform;
};

/// Something that happened, in words for people.
struct FilmNote {
  Time at{};
  std::string text;  ///< one line, ASCII
};

/// All that is known of a run and can be drawn of it. What it points to must outlive it.
struct Film {
  const mjModel_* model = nullptr;
  const Snapshots* snapshots = nullptr;
  std::string title{};                ///< case, gains: a line or two; empty: none
  std::vector<PlannedGoal> goals{};   ///< in any order; of those that overlap the last counts
  std::vector<FilmNote> notes{};      ///< in order of time
  const Snapshots* before = nullptr;  ///< what came before the first: the trace begins there
};

/// What is drawn over a picture.
struct Overlays {
  bool text = true;       ///< time; title and events, where the film has any
  bool goal = false;      ///< planned goals
  bool trace = false;     ///< where the end effector has been in the last seconds
  bool forces = false;    ///< contact forces and pushes as arrows
  bool contacts = false;  ///< where anything touches
  bool limits = false;    ///< where each joint is between its limits
};

/// How a film is drawn.
struct FilmSettings {
  RenderSettings render;  ///< size and quality; its camera is not used
  View view;
  std::vector<Inset> insets{};
  Overlays overlays;
  double trace_s = 3;       ///< how far back the trace goes, s, > 0
  double newton_m = 0.004;  ///< length of an arrow per newton, m, > 0

  /// @throws InputError naming field, value and range; for two insets in one corner.
  void Validate() const;
};

}  // namespace twin::render
