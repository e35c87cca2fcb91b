#pragma once

#include <cstdint>
#include <optional>

#include "record/foxglove.pb.h"
#include "twin/core/joint_vector.h"
#include "twin/core/time.h"

namespace twin::record {

/// The arm's frames over time as messages for viewers: a chain from panda_link0, the base, over
/// panda_link1 .. panda_link8, the flange, to panda_hand, named as the links of
/// models/robots/panda/panda.urdf and hand.urdf. panda_hand is the mounting pose of a Franka Hand,
/// even without one.
///
/// One message per 20 ms of run time, at the first cycle in each interval, so that skipped cycles
/// cause no drift.
///
/// Threads: one thread. Real-time: no.
class ArmFrames {
 public:
  static constexpr Duration kPeriod = std::chrono::milliseconds(20);

  ArmFrames();

  /// @param at  time of a cycle. @param q  measured there, rad.
  /// @returns the message, valid until the next call; null if none is due or q is not finite.
  [[nodiscard]] const foxglove::FrameTransforms* Next(Time at, const JointVector& q);

 private:
  void AddFrame(const char* parent, const char* child);

  foxglove::FrameTransforms message_;
  std::optional<std::int64_t> last_;  ///< index of the last interval with a message
};

}  // namespace twin::record
