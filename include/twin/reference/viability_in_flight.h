#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/reference/viability_filter.h"

namespace twin::reference {

/// A client's action in a cycle whose state it has not received.
struct InFlight {
  bool sent = false;  ///< false: no command
  JointVector c{};    ///< the command if sent, rad or rad/s by the interface in use
};

/// The viability filter for a delayed client: its newest state is d cycles old when it makes a
/// command, and it cannot know which commands sent since have arrived. As commands are positions or
/// velocities, one command means a different jerk in each of the 2^d possible states of the robot:
/// after a lost position, 3 times the lost jerk more.
///
/// The filter sends the command nearest to the requested one that is within the limits and leads
/// into the viable set from all possible states. If none exists, it sends nothing in this cycle,
/// which the robot counts as a loss; after d silent cycles the state is certain, and a command
/// exists. So all limits are kept at all times as long as at most n consecutive cycles pass without
/// an arriving command, silent cycles included; it suffices that at most most_lost() consecutive
/// sent commands are lost. Lemmas and proofs: src/reference/VIABILITY.md.
///
/// The set of commands is not the largest possible. A client that is never silent can keep the
/// limits with positions only at jerks close to zero. Jerks below a quarter of the limit with d =
/// 1, a tenth with d = 2, change slowly enough to pass where nothing is lost.
///
/// Threads: constant after construction. Real-time: noexcept, allocates nothing; up to 2^d times
/// the cost of ViabilityFilter.
class ViabilityInFlight {
 public:
  static constexpr int kMostInFlight = 2;

  /// @param in_flight  d, in [0, kMostInFlight]: age in cycles of a state when it is answered.
  /// @param held  n, at least d: consecutive cycles that the robot bridges.
  /// @throws InputError as ViabilityFilter, and for a d or n out of range.
  explicit ViabilityInFlight(const JointLimits& limits, int in_flight,
                             int held = ViabilityFilter::kLostByDefault);

  /// A filtered command.
  struct Outcome {
    bool send = false;                   ///< false: send nothing in this cycle
    JointVector c{};                     ///< command in the unit of the interface in use
    std::array<bool, kJoints> active{};  ///< joints whose command was changed, if sent
  };

  /// @param q_d, dq_d, ddq_d  the robot's reference in the newest state.
  /// @param since  actions in the cycles from that state's on, oldest first, up to d. With more,
  /// nothing is sent.
  /// @param q_c  requested, rad.
  [[nodiscard]] Outcome Next(const JointVector& q_d, const JointVector& dq_d,
                             const JointVector& ddq_d, std::span<const InFlight> since,
                             const JointVector& q_c) const noexcept TWIN_REALTIME;

  /// The same for the velocity interface. @param dq_c  requested, rad/s.
  [[nodiscard]] Outcome NextVelocity(const JointVector& q_d, const JointVector& dq_d,
                                     const JointVector& ddq_d, std::span<const InFlight> since,
                                     const JointVector& dq_c) const noexcept TWIN_REALTIME;

  /// (n - d) / (d + 1), rounded down: most consecutive sent commands that may be lost.
  [[nodiscard]] int most_lost() const noexcept;
  [[nodiscard]] int in_flight() const noexcept { return in_flight_; }
  [[nodiscard]] const ViableAxis& axis(std::size_t joint) const { return filter_.axis(joint); }

 private:
  enum class Interface { kPosition, kVelocity };

  [[nodiscard]] Outcome NextOn(Interface interface, const JointVector& q_d, const JointVector& dq_d,
                               const JointVector& ddq_d, std::span<const InFlight> since,
                               const JointVector& wish) const noexcept;

  ViabilityFilter filter_;
  int in_flight_;
};

}  // namespace twin::reference
