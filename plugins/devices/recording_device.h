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

namespace twin::devices {

/// Another device, of which every sample that is read also goes into a script (operator_script.h),
/// so that what a person did can be run again: at the time of its Read(), counted from the first
/// Read(). Presses count from the first sample on, as they do for who is led. The first row presses
/// what it takes to come from a session's begin to where the feedback says things are: mode, when
/// the base is led; scale, when motion is fine.
///
///     Read() --SpscRing--> thread of its own --> <path>.partial, at the end <path>
///
/// Threads: Read(), Feel() from one, Finish() from the one that made it once nobody reads any more.
/// Real-time: as the device within; where the file is slower than the samples, some are left out
/// and counted.
class RecordingDevice final : public teleop::Device {
 public:
  /// Told once, when the recording is not whole: why. May be called from the destructor.
  using Tell = std::function<void(std::string_view)>;

  /// How many samples may wait for the disk: eight seconds of a thousand a second.
  static constexpr std::size_t kRingSize = 8192;

  /// Begins the file. @param ring_size  a power of two. @throws InputError when there is one
  /// already: recordings are not replaced; EnvironmentError when it cannot be made.
  RecordingDevice(std::unique_ptr<teleop::Device> device, const std::filesystem::path& path,
                  Tell tell, std::size_t ring_size = kRingSize);
  /// As Finish(); what it would throw is told.
  ~RecordingDevice() override;
  RecordingDevice(const RecordingDevice&) = delete;
  RecordingDevice& operator=(const RecordingDevice&) = delete;

  [[nodiscard]] std::optional<teleop::OperatorSample> Read(Time now) noexcept override;
  void Feel(const teleop::OperatorFeedback& feedback) noexcept override {
    felt_ = feedback;
    device_->Feel(feedback);
  }
  [[nodiscard]] bool lost() const noexcept override { return device_->lost(); }
  [[nodiscard]] std::string Describe() const override;

  /// Writes what is left, and gives the file its name. Once; later calls do nothing.
  /// @throws EnvironmentError when a sample is missing or the file could not be written; it is
  /// <path>.partial then.
  void Finish();

 private:
  /// Sums presses up.
  void Count(const teleop::OperatorSample& sample) noexcept;
  void WriteAll(const std::stop_token& stop);
  void WriteWaiting();

  const std::unique_ptr<teleop::Device> device_;
  const Tell tell_;
  record::PartialFile file_;
  std::optional<Time> begun_;  ///< when Read() was called first
  Time last_{Duration(-1)};    ///< of the newest sample, from then
  teleop::OperatorFeedback felt_;
  std::optional<teleop::OperatorSample> before_;  ///< newest of the device
  teleop::OperatorSample counted_;                ///< presses as the file has them
  rt::SpscRing<teleop::OperatorSample> ring_;
  std::atomic<std::uint64_t> left_out_{0};  ///< relaxed: read once the reader is at rest
  teleop::OperatorSample written_;          ///< newest in the file
  std::string failure_;                     ///< of the thread; read once it has ended
  std::jthread thread_;                     ///< last: it uses all of the above
};

}  // namespace twin::devices
