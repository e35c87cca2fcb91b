#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "twin/control/parameters.h"
#include "twin/core/clock.h"
#include "twin/core/registry.h"
#include "twin/teleop/device.h"

namespace twin::teleop {

/// Arguments of a device's factory. Referenced objects outlive the device, except the parameters,
/// which it reads at once. The caller refuses parameters that were not read.
struct DeviceRequest {
  control::ParameterReader& parameters;
  std::filesystem::path folder;  ///< base of relative file paths
  const MonotonicClock& clock;   ///< for the device's own threads
  /// The run's time is virtual: samples must depend on `now` only, and an operator cannot keep up.
  bool is_lockstep = false;
  std::uint64_t seed = 0;  ///< the run's
};

/// Makes a device. @throws InputError for a parameter out of range or an unknown device, listing
/// the known ones; EnvironmentError naming the cure if this machine does not permit it.
using DeviceFactory = std::function<std::unique_ptr<Device>(const DeviceRequest&)>;

/// The program's devices by name. The program's main fills it from an explicit list.
///
/// Threads: one thread.
class DeviceRegistry : public Registry<DeviceFactory> {
 public:
  DeviceRegistry() : Registry("device") {}
};

}  // namespace twin::teleop
