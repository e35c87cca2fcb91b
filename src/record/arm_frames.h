#pragma once

#include <cstdint>
#include <optional>

#include "record/foxglove.pb.h"
#include "twin/core/joint_vector.h"
#include "twin/core/time.h"

namespace twin::record {

/// The arm's frames over time as a message that viewers read: a tree from panda_link0, the base,
/// over panda_link1 .. panda_link8, the flange, to panda_hand, named as the links of
/// models/robots/panda/panda.urdf and hand.urdf. panda_hand is where a Franka Hand is, or would be.
///
/// One message every 20 ms of the run's time: at the first cycle in each such span, so that
/// skipped cycles shift nothing.
///
/// Threads: one thread. Real-time: no.
class ArmFrames {
 public:
  static constexpr Duration kPeriod = std::chrono::milliseconds(20);

  ArmFrames();

  /// @param at  of a cycle. @param q  measured there, rad.
  /// @returns the message, valid until the next call; null when none is due, or q is not finite.
  [[nodiscard]] const foxglove::FrameTransforms* Next(Time at, const JointVector& q);

 private:
  void AddFrame(const char* parent, const char* child);

  foxglove::FrameTransforms message_;
  std::optional<std::int64_t> last_;  ///< number of the span whose message has been given
};

}  // namespace twin::record
