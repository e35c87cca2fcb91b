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
#include "twin/teleop/device.h"

namespace twin::teleop {

/// What a device's factory gets. All that is referred to outlives the device, but for the
/// parameters: what it needs of them it takes at once. What it did not ask for is refused by the
/// caller.
struct DeviceRequest {
  control::ParameterReader& parameters;
  std::filesystem::path folder;  ///< what relative paths of files are against
  const MonotonicClock& clock;   ///< for what a device does on threads of its own
  /// The run's time is virtual: samples must depend on `now` alone, and people cannot keep up.
  bool is_lockstep = false;
  std::uint64_t seed = 0;  ///< of the run
};

/// Makes a device. @throws InputError for a parameter out of range, and when there is no such
/// device, naming those there are; EnvironmentError when this machine does not permit it, naming
/// the cure.
using DeviceFactory = std::function<std::unique_ptr<Device>(const DeviceRequest&)>;

/// The devices a program knows, by name. Filled from an explicit list by the program's main.
///
/// Threads: one thread.
class DeviceRegistry {
 public:
  /// @pre no device of this name was added.
  void Add(std::string name, DeviceFactory factory);

  /// @throws InputError when there is no such device; the text lists those there are.
  [[nodiscard]] const DeviceFactory& Find(std::string_view name) const;

  /// In the order in which they were added.
  [[nodiscard]] std::vector<std::string> Names() const;

 private:
  std::vector<std::pair<std::string, DeviceFactory>> entries_;
};

}  // namespace twin::teleop
