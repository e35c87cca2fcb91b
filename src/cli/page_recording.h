#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "plugins/devices/recording_device.h"
#include "twin/core/clock.h"
#include "twin/page/operator_channel.h"
#include "twin/teleop/operator_sample.h"

namespace twin::cli {

/// Says, as a note, why a recording is not whole.
void TellOfRecording(std::string_view why);

/// What the record button of the page does: puts what the operator does into a script that device
/// `script` runs again, operator_1.csv, operator_2.csv and so on, whatever is free.
///
/// Threads: the page's; the destructor once that has ended.
class PageRecording {
 public:
  /// @param folder   is made when the first recording begins.
  /// @param channel  whose feedback tells in which mode a recording begins; must outlive this.
  PageRecording(std::filesystem::path folder, page::OperatorChannel& channel);
  ~PageRecording();
  PageRecording(const PageRecording&) = delete;
  PageRecording& operator=(const PageRecording&) = delete;

  /// Begins a recording, or ends it. @returns a line for people; also of what went wrong.
  [[nodiscard]] std::string Switch(bool on);
  /// Keeps it, while a recording goes on.
  void Take(const teleop::OperatorSample& sample);

 private:
  class Tap;

  [[nodiscard]] std::string Begin();
  [[nodiscard]] std::string End();

  const std::filesystem::path folder_;
  page::OperatorChannel& channel_;
  const MonotonicClock clock_;
  std::filesystem::path path_;  ///< of the recording that goes on
  Tap* tap_ = nullptr;          ///< recording_'s
  std::unique_ptr<devices::RecordingDevice> recording_;
};

}  // namespace twin::cli
