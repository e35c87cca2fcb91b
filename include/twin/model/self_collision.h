#pragma once

#include <limits>

#include "twin/core/realtime.h"
#include "twin/model/arm_model.h"

namespace twin::model {

/// Least distance between parts of the arm that can collide within the joint limits, m; negative
/// when they overlap.
///
/// Capsules cover the links: base, column, shoulder, upper arm, forearm, wrist, links 6 and 7, and
/// the Franka Hand with its fingers open. Checked are the parts beyond the upper half of the
/// forearm against those before the elbow, and the hand against the forearm. Other parts touch by
/// design, or the joint limits separate them. The capsules are fitted by hand to the plant's
/// collision shapes, a centimetre or two too large; a test compares them with the plant's contacts.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
/// @param with_hand  whether a Franka Hand is on the flange.
/// @param horizon    m; larger distances need not be computed.
/// @returns the smaller of distance and `horizon`; `horizon` if q is not finite.
[[nodiscard]] double SelfDistance(const Configuration& q, bool with_hand,
                                  double horizon = std::numeric_limits<double>::infinity()) noexcept
    TWIN_REALTIME;

/// Checks cheaply, once per cycle, whether parts of the arm are too close. A joint motion changes
/// the distance by at most the travel of the parts it moves,
///   abs(SelfDistance(q) - SelfDistance(q0)) <= sum_i r_i abs(q_i - q0_i),
/// with r_i the largest distance from joint i's axis of everything beyond it. So the distance is
/// recomputed only after enough travel to be too close.
///
/// Threads: one. Real-time: noexcept, allocates nothing.
class SelfDistanceWatch {
 public:
  explicit SelfDistanceWatch(bool with_hand) noexcept : with_hand_(with_hand) {}

  /// @param clearance  m. @param sines  of q.
  /// @returns SelfDistance(q) if below `clearance`, else a lower bound that is not.
  [[nodiscard]] double Update(const JointVector& q, const Configuration& sines,
                              double clearance) noexcept TWIN_REALTIME;

 private:
  bool with_hand_;
  bool is_known_ = false;
  JointVector q_{};  ///< at the last computation
  double distance_ = 0;
};

}  // namespace twin::model
