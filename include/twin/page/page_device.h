#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "twin/page/operator_channel.h"
#include "twin/teleop/device.h"

namespace twin::page {

/// `sample` with its press counters relative to `before`.
[[nodiscard]] inline teleop::OperatorSample Since(const teleop::OperatorSample& before,
                                                  teleop::OperatorSample sample) noexcept {
  sample.mode_presses -= before.mode_presses;
  sample.gripper_presses -= before.gripper_presses;
  sample.frame_presses -= before.frame_presses;
  sample.scale_presses -= before.scale_presses;
  sample.stop_presses -= before.stop_presses;
  sample.release_presses -= before.release_presses;
  sample.end_presses -= before.end_presses;
  return sample;
}

/// Sticks and buttons on the operator's page. Gives samples only while an operator has control and
/// the browser sends input; without them the reader's last sample becomes too old. Feedback is
/// displayed. Lost once the page has ended.
/// Threads, real-time: as teleop::Device; one device per channel at a time.
class PageDevice final : public teleop::Device {
 public:
  /// Presses that count.
  enum class Presses : std::uint8_t {
    kAll,      ///< an emergency stop before the device is there, too
    kFromNow,  ///< earlier ones were another session's
  };

  /// @param channel  must outlive this object. @param where  the page's address.
  PageDevice(OperatorChannel& channel, std::string where, Presses presses)
      : channel_(channel), where_(std::move(where)) {
    if (presses == Presses::kAll) return;
    if (const teleop::OperatorSample* sample = channel_.NewSample()) before_ = *sample;
  }

  [[nodiscard]] std::optional<teleop::OperatorSample> Read(Time /*now*/) noexcept
      TWIN_REALTIME override {
    const teleop::OperatorSample* sample = channel_.NewSample();
    if (sample == nullptr) return {};
    return Since(before_, *sample);
  }
  void Feel(const teleop::OperatorFeedback& feedback) noexcept TWIN_REALTIME override {
    channel_.Tell(feedback);
  }
  [[nodiscard]] bool lost() const noexcept TWIN_REALTIME override { return channel_.ended(); }
  [[nodiscard]] std::string Describe() const override { return "the page at " + where_; }

 private:
  OperatorChannel& channel_;
  const std::string where_;
  teleop::OperatorSample before_;  ///< counters of presses that do not count
};

}  // namespace twin::page
