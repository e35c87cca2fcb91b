#pragma once

#include <cstddef>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/reference/resampler.h"

namespace twin::reference {

/// A Resampler for poses: position by its coordinates, m; rotation by the components of a unit
/// quaternion, normalised after interpolation. For deposits a few degrees apart this equals the
/// cubic on rotations up to third order in the angle.
///
/// Play time, lag, stop, threads and real-time: as Resampler.
class PoseResampler {
 public:
  /// @param source_rate_hz  as in Resampler. @throws as Resampler.
  explicit PoseResampler(double source_rate_hz) : resampler_(source_rate_hz) {}

  void Reset(const Transform& O_T_EE) noexcept TWIN_REALTIME;
  void Deposit(Time source_time, const Transform& O_T_EE) noexcept TWIN_REALTIME;
  void Advance() noexcept TWIN_REALTIME { resampler_.Advance(); }
  void Stop() noexcept TWIN_REALTIME { resampler_.Stop(); }
  [[nodiscard]] Transform Value(std::size_t cycles = 0) const noexcept TWIN_REALTIME;
  [[nodiscard]] Transform Source() const noexcept TWIN_REALTIME;

 private:
  /// [p; w, x, y, z], with the sign of the quaternion that is nearest to the last one.
  [[nodiscard]] JointVector CoordinatesOf(const Transform& O_T_EE) const noexcept;

  Resampler resampler_;
  JointVector last_{0, 0, 0, 1, 0, 0, 0};
};

}  // namespace twin::reference
