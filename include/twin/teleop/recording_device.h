#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "twin/core/time.h"
#include "twin/record/partial_file.h"
#include "twin/rt/spsc_ring.h"
#include "twin/teleop/device.h"

namespace twin::teleop {

/// Wraps another device and writes every sample to a script (operator_script.h), so that the input
/// can be replayed. A row's time is that of its Read(), counted from the first Read(). The first
/// row contains the presses that lead from a session's initial state to the state in the feedback:
/// mode if the base is driven; scale if motion is fine.
///
///     Read() --SpscRing--> own thread --> <path>.partial, at the end <path>
///
/// Threads: Read(), Feel() from one; Finish() from the constructing thread after the last Read().
/// Real-time: as the inner device; samples that the file is too slow for are dropped and counted.
class RecordingDevice final : public Device {
 public:
  /// Called once, with the reason, if the recording is incomplete; possibly from the destructor.
  using Tell = std::function<void(std::string_view)>;

  /// Capacity of the queue to the disk: eight seconds at 1 kHz.
  static constexpr std::size_t kRingSize = 8192;

  /// Creates the file. @param device  null: of this object only Record() and Feel() are called.
  /// @param before  the last sample that is left out: its presses do not count.
  /// @param ring_size  a power of two. @throws InputError if it exists, because
  /// recordings are not replaced; EnvironmentError if it cannot be created.
  RecordingDevice(std::unique_ptr<Device> device, const std::filesystem::path& path, Tell tell,
                  const OperatorSample& before = {}, std::size_t ring_size = kRingSize);
  /// As Finish(); reports its error to Tell.
  ~RecordingDevice() override;
  RecordingDevice(const RecordingDevice&) = delete;
  RecordingDevice& operator=(const RecordingDevice&) = delete;

  [[nodiscard]] std::optional<OperatorSample> Read(Time now) noexcept override;
  /// Writes a sample that came in another way. For a recording without a device.
  void Record(const OperatorSample& sample, Time now) noexcept;
  void Feel(const OperatorFeedback& feedback) noexcept override {
    felt_ = feedback;
    if (device_) device_->Feel(feedback);
  }
  [[nodiscard]] bool lost() const noexcept override { return device_->lost(); }
  [[nodiscard]] std::string Describe() const override;

  /// Writes the remaining samples and renames the file to its final name. Later calls have no
  /// effect.
  /// @throws EnvironmentError if a sample is missing or the file could not be written; it remains
  /// <path>.partial.
  void Finish() override;

 private:
  /// Accumulates presses.
  void Count(const OperatorSample& sample) noexcept;
  void WriteAll(const std::stop_token& stop);
  void WriteWaiting();

  const std::unique_ptr<Device> device_;
  const Tell tell_;
  record::PartialFile file_;
  std::optional<Time> begun_;  ///< time of the first Read()
  Time last_{Duration(-1)};    ///< time of the newest sample after begun_
  OperatorFeedback felt_;
  OperatorSample before_;   ///< newest sample of the device
  OperatorSample counted_;  ///< presses as in the file
  rt::SpscRing<OperatorSample> ring_;
  std::atomic<std::uint64_t> left_out_{0};  ///< relaxed: read after the reader has ended
  OperatorSample written_;                  ///< newest sample in the file
  std::string failure_;                     ///< of the thread; read after it has ended
  std::jthread thread_;                     ///< last: it uses all members above
};

}  // namespace twin::teleop
