#pragma once

#include <functional>
#include <string_view>

#include "twin/teleop/device_registry.h"

namespace twin::devices {

/// Adds all devices of this folder by their names in scenarios: evdev (a SpaceMouse or a gamepad),
/// network (an external device program), script (a recording). Each also accepts the parameter
/// `record`, the file for its samples (recording_device.h).
/// @param tell  receives one log line, from any thread, for late failures: an incomplete recording.
/// May be empty.
void RegisterDevices(teleop::DeviceRegistry& registry,
                     const std::function<void(std::string_view)>& tell);

}  // namespace twin::devices
