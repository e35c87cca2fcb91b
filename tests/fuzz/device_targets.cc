#include "fuzz/device_targets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "plugins/devices/operator_message.h"
#include "twin/core/error.h"
#include "twin/teleop/operator_ranges.h"
#include "twin/teleop/operator_script.h"

namespace twin::devices::fuzz {
namespace {

using teleop::OperatorSample;

void CheckSample(const OperatorSample& sample) {
  TWIN_CHECK(sample.sequence >= 1);
  const double most = teleop::MostOfAxis(sample.kind);
  for (const double axis : sample.axes) TWIN_CHECK(std::abs(axis) <= most);
}

/// Nothing when the text is refused.
std::optional<std::vector<OperatorSample>> Read(const std::string& text) {
  std::istringstream in(text);
  try {
    return teleop::ReadOperatorScript(in, "fuzz.csv");
  } catch (const InputError& error) {
    const std::string said = error.what();
    TWIN_CHECK(said.starts_with("fuzz.csv") && said.size() < 500);
    TWIN_CHECK(std::ranges::all_of(said, [](char c) { return c >= 0x20 && c < 0x7F; }));
    return {};
  }
}

std::string Written(const std::vector<OperatorSample>& samples) {
  std::string text = teleop::OperatorScriptHeader();
  OperatorSample before;
  for (const OperatorSample& sample : samples) {
    text += teleop::OperatorScriptRow(sample, before);
    before = sample;
  }
  return text;
}

}  // namespace

void OperatorDatagram(std::span<const std::byte> data) {
  if (const auto message = ParseSample(data)) {
    CheckSample(message->sample);
    TWIN_CHECK(message->sample.sequence <= kMostSequence);
    std::array<std::byte, kSampleBytes> again;
    WriteSample(*message, again);
    TWIN_CHECK(std::ranges::equal(again, data));
  }
  if (const auto feedback = ParseFeedback(data)) {
    std::array<std::byte, kFeedbackBytes> again;
    WriteFeedback(*feedback, again);
    TWIN_CHECK(std::ranges::equal(again, data));
  }
}

void OperatorScript(std::span<const std::byte> data) {
  const auto samples = Read(std::string(reinterpret_cast<const char*>(data.data()), data.size()));
  if (!samples) return;
  TWIN_CHECK(!samples->empty());
  const OperatorSample* before = nullptr;
  for (const OperatorSample& sample : *samples) {
    CheckSample(sample);
    TWIN_CHECK(before == nullptr || sample.at > before->at);
    before = &sample;
  }
  const std::string text = Written(*samples);
  const auto again = Read(text);
  TWIN_CHECK(again && again->size() == samples->size());
  TWIN_CHECK(Written(*again) == text);
}

}  // namespace twin::devices::fuzz
