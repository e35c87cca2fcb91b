#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/reference/viable_axis.h"

namespace twin::reference {

/// The last stage before the wire: passes only commands after which the joints' limits of position,
/// velocity, acceleration and jerk can be kept at all times, even if up to n consecutive commands
/// are lost. Admissible commands pass bit by bit; otherwise each joint gets the nearest admissible
/// jerk. No less restrictive filter exists: src/reference/VIABILITY.md.
///
/// The guarantee holds for a robot that aborts after n + 1 consecutive losses, or never has more
/// than n; that holds the acceleration when a command is lost; and whose state, which the command
/// answers, is the last one (older states: ViabilityInFlight). It starts at a viable state; every
/// state at rest inside the range is one.
///
/// Threads: constant after construction. Real-time: noexcept, allocates nothing.
class ViabilityFilter {
 public:
  /// The robot aborts at 20 consecutive losses: the longest run it bridges.
  static constexpr int kLostByDefault = 19;

  /// @param lost  n. @throws InputError as ViableAxis, naming the joint.
  explicit ViabilityFilter(const JointLimits& limits, int lost = kLostByDefault);

  /// A filtered command.
  struct Outcome {
    JointVector q_c{};                   ///< rad; Next() only
    JointVector dq_c{};                  ///< rad/s; NextVelocity() only
    std::array<bool, kJoints> active{};  ///< joints whose command was changed
    [[nodiscard]] bool any() const noexcept;
  };

  /// @param q_d, dq_d, ddq_d  the robot's reference in the answered state.
  /// @param q_c  requested, rad.
  [[nodiscard]] Outcome Next(const JointVector& q_d, const JointVector& dq_d,
                             const JointVector& ddq_d,
                             const JointVector& q_c) const noexcept TWIN_REALTIME;

  /// The same for the velocity interface, where the robot integrates the command.
  /// @param dq_c  requested, rad/s.
  [[nodiscard]] Outcome NextVelocity(const JointVector& q_d, const JointVector& dq_d,
                                     const JointVector& ddq_d,
                                     const JointVector& dq_c) const noexcept TWIN_REALTIME;

  /// Smallest margin of the joints: ViableAxis::Margin.
  [[nodiscard]] double Margin(const JointVector& q_d, const JointVector& dq_d,
                              const JointVector& ddq_d) const noexcept TWIN_REALTIME;

  [[nodiscard]] const ViableAxis& axis(std::size_t joint) const { return axes_[joint]; }

 private:
  /// @returns the state after the nearest admissible jerk; nullopt if that is the requested one.
  [[nodiscard]] std::optional<AxisState> Instead(std::size_t joint, const AxisState& x,
                                                 double wish) const noexcept;

  std::vector<ViableAxis> axes_;  ///< one per joint
};

/// Bounds of one joint. @pre joint < kJoints.
[[nodiscard]] AxisBounds BoundsOf(const JointLimits& limits, std::size_t joint);

}  // namespace twin::reference
