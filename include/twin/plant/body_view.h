#pragma once

#include <string>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/plant/truth_probe.h"

namespace twin::plant {

/// Where a body of the plant is: ground truth, for whoever looks on.
///
/// Threads: the plant's. Real-time: Pose() is noexcept, O(1), allocates nothing.
class BodyView {
 public:
  /// @param truth  must outlive the view. @throws InputError when no body has that name.
  BodyView(const TruthProbe& truth, const std::string& body);

  /// Of the body's frame in the world, as of the last step.
  [[nodiscard]] Transform Pose() const noexcept TWIN_REALTIME;

 private:
  const TruthProbe& truth_;
  int body_ = 0;
};

}  // namespace twin::plant
