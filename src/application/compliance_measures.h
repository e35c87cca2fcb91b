#pragma once

#include <array>
#include <optional>
#include <vector>

#include "application/compliance_cases.h"
#include "application/compliance_trace.h"
#include "twin/application/application.h"

namespace twin::application::compliance {

/// How the end effector gave way to a push.
///
/// The deflection is what the push alone did: at a standstill the way from the mean pose of the
/// half second before it, on the trajectory the difference of the distances from the reference,
/// pushed and untouched, at the same time of the motion. So what the robot's model of gravity is
/// wrong by, which moves a soft spring as well, is no part of it.
struct Response {
  std::vector<double> t{};          ///< since the motion began, s
  std::vector<double> along{};      ///< deflection along the push, m
  std::vector<double> across{};     ///< the rest of it, magnitude, m
  std::vector<double> scripted{};   ///< force of the push, N
  std::vector<double> estimated{};  ///< along the push, as the robot estimates it, in the same way
  double peak = 0;                  ///< largest deflection along the push, m
  double steady = 0;                ///< its mean over the last second of constant force, m
  double expected = 0;              ///< F / K, m
  double force = 0;                 ///< F, N
  double estimated_steady = 0;      ///< of the force, over the same second, N
  /// From the end of the push until the deflection stays within a tenth of the steady one, s;
  /// absent: it had not by the motion's end.
  std::optional<double> settling{};
};

/// How well a reference was followed.
struct Tracking {
  double largest = 0;         ///< m
  double rms = 0;             ///< m
  double largest_turned = 0;  ///< rad
};

/// What the null space did, from half a second after the soft start on: before that, the spring
/// takes over the weight that the robot's model is wrong by.
struct Wandering {
  double joints = 0;        ///< largest way of a joint, rad
  double end_effector = 0;  ///< largest way of the end effector, m
};

/// @param untouched  the same motion without the push; null: the push came at a standstill.
/// @pre pushed is not empty, nor is untouched. @returns nothing when the motion did not come to the
/// push's end.
[[nodiscard]] std::optional<Response> ResponseOf(const Trace& pushed, const Trace* untouched,
                                                 const plant::Push& push, const Gains& gains);

/// @pre the trace is not empty.
[[nodiscard]] Tracking TrackingOf(const Trace& trace);

/// Time in the null space's case from which on its motion counts, s.
[[nodiscard]] double WanderingBegin(const Settings& settings);
[[nodiscard]] std::optional<Wandering> WanderingOf(const Trace& trace, const Settings& settings);

/// All that was measured.
struct Measures {
  std::array<std::optional<Response>, kCases> responses{};
  std::array<std::optional<Tracking>, kCases> trackings{};  ///< of untouched trajectories
  std::optional<Wandering> wandering{};
  double torque = 0;  ///< largest share of a limit
  double rate = 0;    ///< largest share of a limit
  std::uint64_t reflexes = 0;
};

[[nodiscard]] Measures Measure(const Log& log, const Settings& settings, const Pushes& pushes);

/// What is demanded, and what is reported beside it; of cases that were made.
[[nodiscard]] std::vector<Finding> FindingsOf(const Measures& measures);

}  // namespace twin::application::compliance
