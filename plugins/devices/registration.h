#pragma once

#include <functional>
#include <string_view>

#include "twin/teleop/device_registry.h"

namespace twin::devices {

/// Adds every device of this folder, by the name that scenarios give: evdev (a SpaceMouse or a
/// gamepad), network (a device's own program), script (a recording). Each of them also takes the
/// parameter `record`, the file into which its samples go (recording_device.h).
/// @param tell  gets a line, from any thread, about what goes wrong when nobody asks any more: a
/// recording that is not whole. May be empty.
void RegisterDevices(teleop::DeviceRegistry& registry,
                     const std::function<void(std::string_view)>& tell);

}  // namespace twin::devices
