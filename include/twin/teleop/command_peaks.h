#pragma once

#include <array>

#include <Eigen/Core>

#include "twin/core/joint_vector.h"
#include "twin/core/mobile_base.h"
#include "twin/core/realtime.h"
#include "twin/reference/pose_target.h"

namespace twin::teleop {

/// How abrupt commands were: largest norms of second and third differences.
struct Peaks {
  double speed = 0;         ///< m/s or rad/s
  double acceleration = 0;  ///< m/s^2 or rad/s^2
  double jerk = 0;          ///< m/s^3 or rad/s^3
};

/// Peaks of all that is commanded: arm along and about, base ahead and turning.
struct CommandPeaks {
  Peaks along;
  Peaks about;
  Peaks ahead;
  Peaks turning;
};

/// Watches commands from outside: differences of what was given, whoever shaped it.
///
/// Threads: one. Real-time: noexcept, allocates nothing, O(1).
class PeakWatch {
 public:
  /// A motion begins, at rest, there.
  void Begin(const Transform& O_T_EE) noexcept TWIN_REALTIME;

  /// @param T  since the last call, s, > 0. @param is_switch  these count for at_switch() too.
  /// @param is_stopped  the base is in an emergency stop, abrupt by intent: of its commands nothing
  /// counts, and after it they begin at rest.
  void Look(const reference::PoseTarget& target, const BaseTwist& base, double T, bool is_switch,
            bool is_stopped) noexcept TWIN_REALTIME;

  [[nodiscard]] const CommandPeaks& all() const noexcept { return all_; }
  [[nodiscard]] const CommandPeaks& at_switch() const noexcept { return at_switch_; }

 private:
  /// Velocity and acceleration of the last look.
  struct Track {
    Eigen::Vector3d v = Eigen::Vector3d::Zero();
    Eigen::Vector3d a = Eigen::Vector3d::Zero();

    /// @returns the norms now.
    Peaks Next(const Eigen::Vector3d& v_now, double T) noexcept;
  };

  Transform O_T_EE_ = kIdentityTransform;
  std::array<Track, 4> tracks_{};
  CommandPeaks all_;
  CommandPeaks at_switch_;
};

}  // namespace twin::teleop
