#include "plugins/devices/registration.h"

#include <memory>
#include <string>
#include <utility>

#include "plugins/devices/evdev_device.h"
#include "plugins/devices/network_device.h"
#include "plugins/devices/script_device.h"
#include "twin/teleop/recording_device.h"

namespace twin::devices {
namespace {

using Maker = std::unique_ptr<teleop::Device> (*)(const teleop::DeviceRequest&);

/// Wraps the factory `make` with a recording if a file is named.
teleop::DeviceFactory Recorded(Maker make, const std::function<void(std::string_view)>& tell) {
  return [make, tell](const teleop::DeviceRequest& request) {
    std::unique_ptr<teleop::Device> device = make(request);
    const std::string file = request.parameters.Text("record", "");
    if (file.empty()) return device;
    return std::unique_ptr<teleop::Device>(
        std::make_unique<teleop::RecordingDevice>(std::move(device), request.folder / file, tell));
  };
}

}  // namespace

void RegisterDevices(teleop::DeviceRegistry& registry,
                     const std::function<void(std::string_view)>& tell) {
  registry.Add("evdev", Recorded(&MakeEvdevDevice, tell));
  registry.Add("network", Recorded(&MakeNetworkDevice, tell));
  registry.Add("script", Recorded(&MakeScriptDevice, tell));
}

}  // namespace twin::devices
