#pragma once

#include <array>

#include <Eigen/Core>

#include "twin/core/joint_vector.h"
#include "twin/core/mobile_base.h"
#include "twin/core/realtime.h"
#include "twin/reference/target.h"

namespace twin::teleop {

/// Abruptness of commands: largest norms of the differences of first to third order.
struct Peaks {
  double speed = 0;         ///< m/s or rad/s
  double acceleration = 0;  ///< m/s^2 or rad/s^2
  double jerk = 0;          ///< m/s^3 or rad/s^3
};

/// Peaks of all commands: arm translation and rotation, base translation and turning.
struct CommandPeaks {
  Peaks along;
  Peaks about;
  Peaks ahead;
  Peaks turning;
};

/// Measures commands from outside, by differences, whatever produced them.
///
/// Threads: one. Real-time: noexcept, does not allocate, O(1).
class PeakWatch {
 public:
  /// Starts a motion at rest at this pose.
  void Begin(const Transform& O_T_EE) noexcept TWIN_REALTIME;

  /// @param T  since the last call, s, > 0. @param is_switch  also count these peaks for
  /// at_switch().
  /// @param is_stopped  emergency stop of the base, abrupt by design: its commands are ignored
  /// until it ends, and then start at rest.
  void Look(const reference::PoseTarget& target, const BaseTwist& base, double T, bool is_switch,
            bool is_stopped) noexcept TWIN_REALTIME;

  [[nodiscard]] const CommandPeaks& all() const noexcept { return all_; }
  [[nodiscard]] const CommandPeaks& at_switch() const noexcept { return at_switch_; }

 private:
  /// Velocity and acceleration of the last call.
  struct Track {
    Eigen::Vector3d v = Eigen::Vector3d::Zero();
    Eigen::Vector3d a = Eigen::Vector3d::Zero();

    /// @returns the current norms.
    Peaks Next(const Eigen::Vector3d& v_now, double T) noexcept;
  };

  Transform O_T_EE_ = kIdentityTransform;
  std::array<Track, 4> tracks_{};
  CommandPeaks all_;
  CommandPeaks at_switch_;
};

}  // namespace twin::teleop
