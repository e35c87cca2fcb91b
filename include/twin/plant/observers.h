#pragma once

#include <string>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/plant/truth_probe.h"
#include "twin/record/scene_record.h"

namespace twin::plant {

/// Pose of a body of the plant: ground truth, for observers.
///
/// Threads: the plant's. Real-time: Pose() is noexcept, O(1), allocates nothing.
class BodyView {
 public:
  /// @param truth  must outlive the view. @throws InputError if no body has that name.
  BodyView(const TruthProbe& truth, const std::string& body);

  /// Pose of the body's frame in the world after the last step.
  [[nodiscard]] Transform Pose() const noexcept TWIN_REALTIME;

 private:
  const TruthProbe& truth_;
  int body_ = 0;
};

/// Captures poses and forces: contacts with a force, in the engine's order, and pushes on bodies,
/// each as one force on the line that gives its moment about the body's centre of mass (a pure
/// torque is omitted).
///
/// Threads: the plant's. Real-time: noexcept, O(contacts + bodies), allocates nothing.
/// @pre truth.qpos_size() <= record::SceneRecord::kMostPositions.
void CaptureScene(Time now, const TruthProbe& truth,
                  record::SceneRecord& scene) noexcept TWIN_REALTIME;

}  // namespace twin::plant
