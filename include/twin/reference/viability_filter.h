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

/// Stands last before the wire and lets no command pass from which the joints' limits of position,
/// velocity, acceleration and jerk could not be kept for ever, whatever up to n commands in a row
/// are lost. What is admissible passes as it is, bit by bit; of the rest, the nearest admissible
/// jerk of each joint is sent. There is no less restrictive filter: src/reference/VIABILITY.md.
///
/// The promise holds for a robot that aborts after n + 1 losses in a row, or loses no more; that
/// holds the acceleration of a lost command; and whose state, which the command answers, is the one
/// before (ViabilityInFlight: an older one). It begins at a viable state: every one at rest inside
/// the range is.
///
/// Threads: constant after construction. Real-time: noexcept, allocates nothing.
class ViabilityFilter {
 public:
  /// The robot aborts at 20 in a row: the longest run it bridges.
  static constexpr int kLostByDefault = 19;

  /// @param lost  n. @throws InputError as ViableAxis, naming the joint.
  explicit ViabilityFilter(const JointLimits& limits, int lost = kLostByDefault);

  /// What was made of a command.
  struct Outcome {
    JointVector q_c{};                   ///< rad; Next() only
    JointVector dq_c{};                  ///< rad/s; NextVelocity() only
    std::array<bool, kJoints> active{};  ///< joints whose command was changed
    [[nodiscard]] bool any() const noexcept;
  };

  /// @param q_d, dq_d, ddq_d  the robot's reference, of the state being answered.
  /// @param q_c  wished, rad.
  [[nodiscard]] Outcome Next(const JointVector& q_d, const JointVector& dq_d,
                             const JointVector& ddq_d,
                             const JointVector& q_c) const noexcept TWIN_REALTIME;

  /// The same on the velocity interface, where the robot integrates the command. @param dq_c
  /// wished, rad/s.
  [[nodiscard]] Outcome NextVelocity(const JointVector& q_d, const JointVector& dq_d,
                                     const JointVector& ddq_d,
                                     const JointVector& dq_c) const noexcept TWIN_REALTIME;

  /// Least of the joints' margins: ViableAxis::Margin.
  [[nodiscard]] double Margin(const JointVector& q_d, const JointVector& dq_d,
                              const JointVector& ddq_d) const noexcept TWIN_REALTIME;

  [[nodiscard]] const ViableAxis& axis(std::size_t joint) const { return axes_[joint]; }

 private:
  /// @returns where the nearest admissible jerk leads to; nothing when that is the wished one.
  [[nodiscard]] std::optional<AxisState> Instead(std::size_t joint, const AxisState& x,
                                                 double wish) const noexcept;

  std::vector<ViableAxis> axes_;  ///< one for each joint
};

/// The bounds of one joint. @pre joint < kJoints.
[[nodiscard]] AxisBounds BoundsOf(const JointLimits& limits, std::size_t joint);

}  // namespace twin::reference
