#pragma once

#include <string_view>

#include "twin/teleop/device_registry.h"

namespace twin::devices {

/// For devices whose samples come on the wall clock. @param device  its name in the registry.
/// @throws InputError when the run's time is virtual.
void RefuseLockstep(const teleop::DeviceRequest& request, std::string_view device);

}  // namespace twin::devices
