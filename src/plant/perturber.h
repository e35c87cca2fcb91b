#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <mujoco/mujoco.h>

#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/plant/perturbation.h"

namespace twin::plant {

/// Puts perturbations into the engine: it alone writes mjData::xfrc_applied.
///
/// Threads: one thread. Real-time: Apply(), BeginMotion() and Restart() are noexcept and allocate
/// nothing.
class Perturber {
 public:
  /// @param model  must outlive this.
  explicit Perturber(const mjModel& model) : model_(model) {}

  /// From the next Apply() on. May allocate.
  /// @throws InputError when a field is out of range, or the model has no such body (names those it
  /// has).
  void Add(const Perturbation& perturbation);

  /// Forgets all, and takes their forces away.
  void Clear(mjData& data);

  /// Plant time starts anew: every hand has still to take hold, and no motion has been.
  void Restart() noexcept;

  /// A motion begins at plant time `now`.
  void BeginMotion(Duration now) noexcept TWIN_REALTIME;

  /// Sets the forces of the step that begins at plant time `begin`.
  /// @pre data.xpos, xmat, xipos and cvel are of the state at `begin`.
  void Apply(Duration begin, mjData& data) noexcept TWIN_REALTIME;

 private:
  struct Entry {
    Perturbation what;
    int body = 0;  ///< in the model
    /// Plant time that its begin counts from; absent: its motion has not begun.
    std::optional<Duration> origin;
    bool holds = false;
    Vector3 from{};  ///< where the hand took hold; valid while `holds`
  };

  void ClearForces(mjData& data) const noexcept TWIN_REALTIME;
  void Act(const Push& push, const Entry& entry, Duration at,
           mjData& data) const noexcept TWIN_REALTIME;
  void Act(const HandSpring& spring, Entry& entry, Duration at,
           mjData& data) const noexcept TWIN_REALTIME;

  const mjModel& model_;
  std::vector<Entry> entries_;
  std::uint32_t motions_ = 0;  ///< begun since Restart()
};

}  // namespace twin::plant
