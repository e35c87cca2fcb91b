#pragma once

#include <limits>

#include "twin/core/realtime.h"
#include "twin/model/arm_model.h"

namespace twin::model {

/// The least distance between parts of the arm that can meet within the joint limits, m; negative
/// when they overlap.
///
/// The arm is made of capsules that cover its links: base, column, shoulder, upper arm, forearm,
/// wrist, links 6 and 7, and the Franka Hand with its fingers open. Compared are the parts beyond
/// the upper half of the forearm with those before the elbow, and the hand with the forearm. Other
/// parts touch by construction, or the joint limits keep them apart.
/// The capsules are ours: fitted by hand to the shapes the twin's plant collides with, by a
/// centimetre or two too large, and compared with its contacts by a test.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
/// @param with_hand  whether a Franka Hand is on the flange.
/// @param horizon    m; beyond it the distance need not be known.
/// @returns the distance or `horizon`, whichever is less; `horizon` when q is not finite.
[[nodiscard]] double SelfDistance(const Configuration& q, bool with_hand,
                                  double horizon = std::numeric_limits<double>::infinity()) noexcept
    TWIN_REALTIME;

/// Tells cheaply, cycle by cycle, whether parts of the arm are too close. A joint's motion changes
/// the distance by no more than the parts it moves against others travel,
///   abs(SelfDistance(q) - SelfDistance(q0)) <= sum_i r_i abs(q_i - q0_i),
/// r_i the largest distance of what lies beyond joint i from its axis, so the distance is computed
/// anew only when the arm has come far enough to be too close.
///
/// Threads: one. Real-time: noexcept, allocates nothing.
class SelfDistanceWatch {
 public:
  explicit SelfDistanceWatch(bool with_hand) noexcept : with_hand_(with_hand) {}

  /// @param clearance  m. @param sines  of q.
  /// @returns SelfDistance(q) if that is below `clearance`, else a lower bound of it that is not.
  [[nodiscard]] double Update(const JointVector& q, const Configuration& sines,
                              double clearance) noexcept TWIN_REALTIME;

 private:
  bool with_hand_;
  bool is_known_ = false;
  JointVector q_{};  ///< where the distance was computed
  double distance_ = 0;
};

}  // namespace twin::model
