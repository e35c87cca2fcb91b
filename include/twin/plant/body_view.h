#pragma once

#include <string>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/plant/truth_probe.h"

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

}  // namespace twin::plant
