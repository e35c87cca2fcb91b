#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <mujoco/mujoco.h>

#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/plant/perturbation.h"

namespace twin::plant {

/// Applies perturbations to the engine; the only writer of mjData::xfrc_applied.
///
/// Threads: one thread. Real-time: Apply(), BeginMotion() and Restart() are noexcept and allocate
/// nothing.
class Perturber {
 public:
  /// @param model  must outlive this.
  explicit Perturber(const mjModel& model) : model_(model) {}

  /// Adds a perturbation from the next Apply() on. May allocate.
  /// @throws InputError if a field is out of range, or for an unknown body (listing the known
  /// ones).
  void Add(const Perturbation& perturbation);

  /// Removes all perturbations and their forces.
  void Clear(mjData& data);

  /// Restarts plant time: no hand grips, and no motion has started.
  void Restart() noexcept;

  /// Notes that a motion starts at plant time `now`.
  void BeginMotion(Duration now) noexcept TWIN_REALTIME;

  /// Sets the forces of the step that starts at plant time `begin`.
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

  void ClearForces(mjData& data) const noexcept TWIN_REALTIME;
  void Act(const Push& push, const Entry& entry, Duration at,
           mjData& data) const noexcept TWIN_REALTIME;
  void Act(const HandSpring& spring, Entry& entry, Duration at,
           mjData& data) const noexcept TWIN_REALTIME;

  const mjModel& model_;
  std::vector<Entry> entries_;
  std::uint32_t motions_ = 0;  ///< started since Restart()
};

}  // namespace twin::plant
