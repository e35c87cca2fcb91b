#pragma once

#include <string_view>

#include "twin/teleop/device_registry.h"

namespace twin::devices {

/// For devices with samples on the wall clock. @param device  its name in the registry.
/// @throws InputError if the run's time is virtual.
void RefuseLockstep(const teleop::DeviceRequest& request, std::string_view device);

}  // namespace twin::devices
