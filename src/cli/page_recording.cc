#include "cli/page_recording.h"

#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "cli/say.h"
#include "twin/core/error.h"
#include "twin/teleop/device.h"

namespace twin::cli {

void TellOfRecording(std::string_view why) {
  Say(stderr, fmt::format("panda-twin: note: {}\n", why));
}

/// A device that gives what it was given.
class PageRecording::Tap final : public teleop::Device {
 public:
  void Put(const teleop::OperatorSample& sample) { next_ = sample; }
  [[nodiscard]] std::optional<teleop::OperatorSample> Read(Time /*now*/) noexcept override {
    return std::exchange(next_, std::nullopt);
  }
  void Feel(const teleop::OperatorFeedback& /*feedback*/) noexcept override {}
  [[nodiscard]] bool lost() const noexcept override { return false; }
  [[nodiscard]] std::string Describe() const override { return "the operator's page"; }

 private:
  std::optional<teleop::OperatorSample> next_;
};

PageRecording::PageRecording(std::filesystem::path folder, page::OperatorChannel& channel)
    : folder_(std::move(folder)), channel_(channel) {}

PageRecording::~PageRecording() {
  if (recording_) static_cast<void>(End());
}

std::string PageRecording::Switch(bool on) {
  try {
    if (on && !recording_) return Begin();
    if (!on && recording_) return End();
  } catch (const Error& error) {
    recording_.reset();
    return fmt::format("nothing is recorded: {}", error.what());
  }
  return on ? fmt::format("recording goes on into {}", path_.string()) : "nothing was recorded";
}

void PageRecording::Take(const teleop::OperatorSample& sample) {
  if (!recording_) return;
  if (const auto* feedback = channel_.Feedback()) recording_->Feel(*feedback);
  tap_->Put(sample);
  static_cast<void>(recording_->Read(clock_.Now()));
}

std::string PageRecording::Begin() {
  std::error_code ignored;  // what cannot be made is told when the file is
  std::filesystem::create_directories(folder_, ignored);
  for (int i = 1;; ++i) {
    path_ = folder_ / fmt::format("operator_{}.csv", i);
    if (!std::filesystem::exists(path_, ignored)) break;
  }
  auto tap = std::make_unique<Tap>();
  Tap* const given = tap.get();
  recording_ = std::make_unique<devices::RecordingDevice>(std::move(tap), path_, &TellOfRecording);
  tap_ = given;
  return fmt::format("recording what the operator does into {}", path_.string());
}

std::string PageRecording::End() {
  const std::unique_ptr<devices::RecordingDevice> recording = std::move(recording_);
  recording->Finish();
  return fmt::format("recorded: {}; device script runs it again", path_.string());
}

}  // namespace twin::cli
