#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "twin/core/limits.h"
#include "twin/core/time.h"
#include "twin/page/live_feed.h"
#include "twin/page/live_page.h"
#include "twin/reference/viability_filter.h"

namespace twin::page {

/// Current data as the members of a JSON object: arm, base, hand, camera.
///
/// The margin is reference::ViabilityFilter's for the arm's reference q_d with the losses that the
/// robot bridges, whether or not the run uses the filter. No margin under torque control.
///
/// Threads: one.
class Status {
 public:
  /// @param scene, arm  must outlive this object, with all that they point to.
  Status(const JointLimits& limits, const PageScene& scene, rt::LatestValue<ArmView>& arm);

  /// Time of the newest state of the arm, on the run's clock; 0 before the first.
  [[nodiscard]] Time now();

  /// The newest state of the arm; null before the first. Valid until the next call of now().
  [[nodiscard]] const ArmView* arm() const noexcept {
    return arm_.has_value() ? &arm_.value() : nullptr;
  }

  void SetNoPicture(std::string why) { no_picture_ = std::move(why); }

  /// @param camera  the selected one.
  [[nodiscard]] std::string Text(std::size_t camera);

 private:
  [[nodiscard]] std::string ArmText() const;
  [[nodiscard]] std::string BaseText() const;
  [[nodiscard]] std::string HandText();

  std::optional<reference::ViabilityFilter> filter_;  ///< nullopt: these limits permit no filter
  const backend::Hand* hand_;
  rt::LatestValue<ArmView>& arm_;
  std::string no_picture_;
};

}  // namespace twin::page
