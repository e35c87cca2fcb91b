#include "plugins/devices/script_device.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/teleop/operator_script.h"

namespace twin::devices {
namespace {

using teleop::OperatorSample;

/// The sample that ends a session.
OperatorSample EndAfter(const OperatorSample& last) {
  OperatorSample end = last;
  end.at += ScriptDevice::kEndAfter;
  if (end.kind == teleop::AxisKind::kRate) end.axes = {};
  ++end.end_presses;
  return end;
}

}  // namespace

ScriptDevice::ScriptDevice(std::vector<OperatorSample> samples, std::string name,
                           const ScriptSettings& settings)
    : samples_(std::move(samples)), name_(std::move(name)), repeat_(settings.repeat) {
  TWIN_CHECK(!samples_.empty());
  const bool is_ended = samples_.back().end_presses > 0;
  if (settings.ends && !is_ended) samples_.push_back(EndAfter(samples_.back()));
}

Duration ScriptDevice::Pause() const noexcept {
  if (next_ == 0) return Duration::zero();
  return next_ == samples_.size() ? kHeartbeat : repeat_;
}

OperatorSample ScriptDevice::Give(Time now) noexcept {
  given_ = now;
  OperatorSample sample = samples_[next_ - 1];
  sample.sequence = ++sequence_;
  sample.at = now;
  return sample;
}

std::optional<OperatorSample> ScriptDevice::Read(Time now) noexcept {
  if (!begun_) begun_ = now;
  const Time at{now - *begun_};
  const std::size_t before = next_;
  while (next_ < samples_.size() && samples_[next_].at <= at) ++next_;
  if (next_ > before) return Give(now);
  const OperatorSample& last = samples_.back();
  const Duration lasting = last.end_presses > 0 ? kEndLasts : Duration::zero();
  if (next_ == samples_.size() && at > last.at + lasting) {
    lost_.store(true, std::memory_order_relaxed);
    return {};
  }
  const Duration pause = Pause();
  const bool is_repeated = pause > Duration::zero() && now - given_ >= pause;
  if (is_repeated) return Give(now);
  return {};
}

std::string ScriptDevice::Describe() const {
  return fmt::format("{} ({} samples, {:.1f} s)", name_, samples_.size(),
                     ToSeconds(samples_.back().at.time_since_epoch()));
}

std::unique_ptr<teleop::Device> MakeScriptDevice(const teleop::DeviceRequest& request) {
  control::ParameterReader& parameters = request.parameters;
  const std::string file = parameters.Text("file", "");
  if (file.empty()) parameters.Refuse("file", "is missing; name the recording to be replayed");
  ScriptSettings settings;
  settings.repeat =
      parameters.Time("repeat", Duration::zero(), Duration::zero(), std::chrono::seconds(10));
  settings.ends = parameters.Choice("at_end", "end", {"end", "lost"}) == "end";
  const std::filesystem::path path = request.folder / file;
  return std::make_unique<ScriptDevice>(teleop::ReadOperatorScript(path), path.filename().string(),
                                        settings);
}

}  // namespace twin::devices
