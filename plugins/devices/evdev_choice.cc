#include <algorithm>
#include <cctype>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "plugins/devices/evdev_device.h"
#include "plugins/devices/lockstep_refusal.h"
#include "twin/core/error.h"

namespace twin::devices {
namespace {

std::string Lower(std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

/// Selection of an input device.
struct Choice {
  std::string path;
  std::string name;  ///< part of it, in lower case
};

/// Lists the devices found instead.
std::string Others(const std::vector<FoundDevice>& found) {
  std::vector<std::string> usable;
  std::size_t closed = 0;
  for (const FoundDevice& device : found) {
    if (!device.why_not.empty()) {
      ++closed;
    } else if (KindOf(device.capabilities)) {
      usable.push_back(fmt::format("{} ({})", device.capabilities.name, device.path.string()));
    }
  }
  std::string text =
      usable.empty() ? "there is none" : fmt::format("there are: {}", fmt::join(usable, ", "));
  if (closed > 0) {
    text += fmt::format("; {} more could not be opened (are you in the group input?)", closed);
  }
  return text;
}

/// The first SpaceMouse, or else the first gamepad, of the matching devices.
std::filesystem::path Choose(const Choice& choice) {
  if (!choice.path.empty()) return choice.path;
  const std::vector<FoundDevice> found = FindEventDevices();
  for (const EvdevKind wanted : {EvdevKind::kSpaceMouse, EvdevKind::kGamepad}) {
    for (const FoundDevice& device : found) {
      const bool is_meant = Lower(device.capabilities.name).find(choice.name) != std::string::npos;
      if (is_meant && KindOf(device.capabilities) == wanted) return device.path;
    }
  }
  throw InputError(fmt::format(
      "no SpaceMouse and no gamepad{}; {}; panda-twin devices shows more",
      choice.name.empty() ? "" : fmt::format(" called \"{}\"", choice.name), Others(found)));
}

/// @throws InputError also if the device is unsuitable.
std::unique_ptr<EventSource> OpenLeading(const std::filesystem::path& path) {
  std::unique_ptr<EventSource> source = OpenEventSource(path);
  if (KindOf(source->capabilities())) return source;
  throw InputError(
      fmt::format("{}: \"{}\" has neither six axes nor a gamepad's sticks and buttons; {}",
                  path.string(), source->capabilities().name, Others(FindEventDevices())));
}

}  // namespace

std::unique_ptr<teleop::Device> MakeEvdevDevice(const teleop::DeviceRequest& request) {
  RefuseLockstep(request, "evdev");
  control::ParameterReader& parameters = request.parameters;
  const Choice choice{parameters.Text("path", ""), Lower(parameters.Text("name", ""))};
  const std::filesystem::path path = Choose(choice);
  std::unique_ptr<EventSource> source = OpenLeading(path);
  const EvdevCapabilities& capabilities = source->capabilities();
  EvdevSettings settings;
  settings.profile = UsualProfile(*KindOf(capabilities), capabilities);
  ApplyParameters(parameters, capabilities, settings.profile);
  settings.full_rumble =
      parameters.Quantity("full_rumble", Dimension::kForce, settings.full_rumble, 0, 1000);
  settings.where = path.string();
  // After replugging its number may differ, so it is found by its full name.
  const Choice again{choice.path, Lower(capabilities.name)};
  return std::make_unique<EvdevDevice>(
      request.clock, std::move(source), [again] { return OpenLeading(Choose(again)); },
      std::move(settings));
}

}  // namespace twin::devices
