#pragma once

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/plant/perturbation.h"

namespace twin::plant {

/// Position and derivative of the minimum-jerk path from 0 to 1, at x in [0, 1].
struct PathPoint {
  double s = 0;
  double ds = 0;  ///< ds/dx
};

/// s = 10 x^3 - 15 x^4 + 6 x^5; x is clamped to [0, 1].
[[nodiscard]] constexpr PathPoint MinimumJerk(double x) noexcept {
  x = std::clamp(x, 0.0, 1.0);
  return {x * x * x * (10 + x * (-15 + 6 * x)), 30 * x * x * (1 - x) * (1 - x)};
}

/// Applies perturbations to the engine; one for each arm, beside Suction the only writers of
/// mjData::xfrc_applied.
///
/// Threads: one thread. Real-time: Apply(), BeginMotion() and Restart() are noexcept and allocate
/// nothing.
class Perturber {
 public:
  /// @param model  must outlive this. @param prefix  of the arm's bodies, among several arms.
  explicit Perturber(const mjModel& model, std::string prefix = {})
      : model_(&model), prefix_(std::move(prefix)) {}

  /// Adds a perturbation from the next Apply() on. May allocate. Its body is sought among the
  /// arm's own first, whose names it gives without the prefix.
  /// @throws InputError if a field is out of range, or for an unknown body (listing the known
  /// ones).
  void Add(const Perturbation& perturbation);

  /// Removes all perturbations and their forces.
  void Clear(mjData& data);

  /// Restarts plant time: no hand grips, and no motion has started.
  void Restart() noexcept;

  /// Notes that a motion starts at plant time `now`.
  void BeginMotion(Duration now) noexcept TWIN_REALTIME;

  /// Takes the forces of the last step back; before the first Apply() of a step.
  void ClearForces(mjData& data) const noexcept TWIN_REALTIME;

  /// Adds the forces of the step that starts at plant time `begin`.
  /// @pre data.xpos, xmat, xipos and cvel are of the state at `begin`.
  void Apply(Duration begin, mjData& data) noexcept TWIN_REALTIME;

 private:
  struct Entry {
    Perturbation what;
    int body = 0;  ///< in the model
    /// Plant time of its origin; absent before its motion.
    std::optional<Duration> origin;
    bool holds = false;
    Vector3 from{};  ///< position at the grip; valid while `holds`
  };

  void Act(const Push& push, const Entry& entry, Duration at,
           mjData& data) const noexcept TWIN_REALTIME;
  void Act(const HandSpring& spring, Entry& entry, Duration at,
           mjData& data) const noexcept TWIN_REALTIME;

  const mjModel* model_;
  std::string prefix_;
  std::vector<Entry> entries_;
  std::uint32_t motions_ = 0;  ///< started since Restart()
};

}  // namespace twin::plant
