#include "twin/teleop/recording_device.h"

#include <algorithm>
#include <span>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/rt/host_time.h"
#include "twin/teleop/operator_ranges.h"
#include "twin/teleop/operator_script.h"

namespace twin::teleop {
namespace {

constexpr Duration kBetweenWrites = std::chrono::milliseconds(20);

void Append(record::PartialFile& file, const std::string& text) {
  file.Write(std::as_bytes(std::span(text)));
}

const std::filesystem::path& NewFile(const std::filesystem::path& path) {
  std::error_code unknown;
  if (!std::filesystem::exists(path, unknown)) return path;
  throw InputError(
      fmt::format("{}: exists, and a recording is not replaced; remove it, or name another one",
                  path.string()));
}

}  // namespace

RecordingDevice::RecordingDevice(std::unique_ptr<Device> device, const std::filesystem::path& path,
                                 Tell tell, const OperatorSample& before, std::size_t ring_size)
    : device_(std::move(device)),
      tell_(std::move(tell)),
      file_(NewFile(path), record::PartialFile::Leftover::kKeep),
      before_(before),
      ring_(ring_size) {
  Append(file_, OperatorScriptHeader());
  thread_ = std::jthread([this](const std::stop_token& stop) { WriteAll(stop); });
}

RecordingDevice::~RecordingDevice() {
  try {
    Finish();
  } catch (const Error& error) {
    if (tell_) tell_(error.what());
  }
}

std::optional<OperatorSample> RecordingDevice::Read(Time now) noexcept {
  if (!begun_) begun_ = now;
  const auto sample = device_->Read(now);
  if (sample) Record(*sample, now);
  return sample;
}

void RecordingDevice::Record(const OperatorSample& sample, Time now) noexcept {
  if (!begun_) begun_ = now;
  Count(sample);
  // Row times must rise, even for two calls at one instant.
  last_ = std::max(Time(now - *begun_), last_ + Duration(1));
  const bool is_kept = ring_.TryPushWith([&](OperatorSample& slot) {
    slot = sample;
    slot.at = last_;
    for (const auto presses : kPresses) slot.*presses = counted_.*presses;
  });
  if (!is_kept) left_out_.fetch_add(1, std::memory_order_relaxed);
}

void RecordingDevice::Count(const OperatorSample& sample) noexcept {
  const bool is_first = last_ < Time{};
  if (is_first) {
    counted_.mode_presses = felt_.mode == Mode::kBase ? 1 : 0;
    counted_.scale_presses = felt_.fine ? 1 : 0;
  }
  for (const auto presses : kPresses) {
    counted_.*presses += PressesSince(before_.*presses, sample.*presses);
  }
  before_ = sample;
}

std::string RecordingDevice::Describe() const {
  return fmt::format("{}, recorded into {}", device_->Describe(), file_.path().string());
}

void RecordingDevice::WriteWaiting() {
  std::string rows;
  while (ring_.TryPopWith([&](const OperatorSample& sample) {
    rows += OperatorScriptRow(sample, written_);
    written_ = sample;
  })) {
  }
  if (!rows.empty()) Append(file_, rows);
}

void RecordingDevice::WriteAll(const std::stop_token& stop) {
  try {
    while (!stop.stop_requested()) {
      WriteWaiting();
      rt::Pause(kBetweenWrites);
    }
    WriteWaiting();
  } catch (const Error& error) {
    failure_ = error.what();
  }
}

void RecordingDevice::Finish() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
  if (!failure_.empty()) throw EnvironmentError(failure_);
  const std::uint64_t left_out = left_out_.load(std::memory_order_relaxed);
  if (left_out > 0) {
    throw EnvironmentError(
        fmt::format("{}.partial: {} samples are missing, since the disk was slower than they came; "
                    "the recording would not run as it was",
                    file_.path().string(), left_out));
  }
  file_.Commit();
}

}  // namespace twin::teleop
