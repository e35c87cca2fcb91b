#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/reference/viability_filter.h"

namespace twin::reference {

/// What a client did in a cycle of which it has not seen the state yet.
struct InFlight {
  bool sent = false;  ///< false: it was silent
  JointVector c{};    ///< the command, rad or rad/s by the interface in use; when sent
};

/// The viability filter of a client that is late: the newest state it has when it makes a command
/// is d cycles old, and which of the commands sent since have arrived it cannot know. As commands
/// are positions or velocities, one command is another jerk in each of the 2^d states that the
/// robot may be in: after a position that was lost, 3 times the lost jerk more.
///
/// What is sent is the command nearest to the wished one that is within the limits and leads into
/// the viable set from every one of those states. When no command does, nothing is sent in this
/// cycle, which the robot takes for a loss; after d silent cycles the state is certain, and from it
/// a command exists. So as long as no more than n cycles in a row pass without a command that
/// arrives, silent ones among them, all limits are kept for ever. That is so when of the commands
/// sent no more than most_lost() in a row are lost. Lemmas and proofs: src/reference/VIABILITY.md.
///
/// The set of commands is not the largest possible; but a client that is never silent cannot keep
/// the limits with positions at all, but for jerks that are next to none. Jerks below a quarter of
/// the limit with d = 1, a tenth with d = 2, change slowly enough to pass where nothing is lost.
///
/// Threads: constant after construction. Real-time: noexcept, allocates nothing; up to 2^d times
/// the cost of ViabilityFilter.
class ViabilityInFlight {
 public:
  static constexpr int kMostInFlight = 2;

  /// @param in_flight  d, in [0, kMostInFlight]: how many cycles old a state is when it is
  /// answered. @param held  n, at least d: the cycles in a row that the robot bridges.
  /// @throws InputError as ViabilityFilter, and for a d or n out of range.
  explicit ViabilityInFlight(const JointLimits& limits, int in_flight,
                             int held = ViabilityFilter::kLostByDefault);

  /// What was made of a command.
  struct Outcome {
    bool send = false;                   ///< false: send nothing in this cycle
    JointVector c{};                     ///< to be sent, in the unit of the interface in use
    std::array<bool, kJoints> active{};  ///< joints whose command was changed; when it is sent
  };

  /// @param q_d, dq_d, ddq_d  the robot's reference, of the newest state.
  /// @param since  what was done in the cycles from that state's on, oldest first; as many as
  /// there were, up to d. More: nothing is sent.
  /// @param q_c  wished, rad.
  [[nodiscard]] Outcome Next(const JointVector& q_d, const JointVector& dq_d,
                             const JointVector& ddq_d, std::span<const InFlight> since,
                             const JointVector& q_c) const noexcept TWIN_REALTIME;

  /// The same on the velocity interface. @param dq_c  wished, rad/s.
  [[nodiscard]] Outcome NextVelocity(const JointVector& q_d, const JointVector& dq_d,
                                     const JointVector& ddq_d, std::span<const InFlight> since,
                                     const JointVector& dq_c) const noexcept TWIN_REALTIME;

  /// (n - d) / (d + 1), rounded down: of the commands sent, how many may be lost in a row.
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
