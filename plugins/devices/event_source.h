#pragma once

#include <linux/input.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "plugins/devices/evdev_profile.h"

namespace twin::devices {

/// Where the events of an input device come from: an open /dev/input/event*, or what stands in for
/// one in tests. Threads: one.
class EventSource {
 public:
  enum class Result : std::uint8_t {
    kEvent,
    kNone,  ///< none waits
    kGone,  ///< unplugged
  };
  virtual ~EventSource() = default;

  [[nodiscard]] virtual const EvdevCapabilities& capabilities() const = 0;
  /// What becomes readable when an event comes.
  [[nodiscard]] virtual int fd() const = 0;
  /// The next event that waits; does not block.
  [[nodiscard]] virtual Result Next(input_event& event) = 0;
  /// @param strength  in [0, 1]; lasts a second unless it is told anew.
  virtual void Rumble(double strength) = 0;
};

/// Opens one. What was missed when events came too fast is told again by what it leads to.
/// @throws InputError when there is none at `path`, or it is no input device; EnvironmentError when
/// it may not be read, with the cure.
[[nodiscard]] std::unique_ptr<EventSource> OpenEventSource(const std::filesystem::path& path);

/// An input device of this machine.
struct FoundDevice {
  std::filesystem::path path;
  EvdevCapabilities capabilities;  ///< empty when it could not be opened
  std::string why_not{};           ///< empty when it could
};

/// All there are, by number. @param folder  where they are.
[[nodiscard]] std::vector<FoundDevice> FindEventDevices(
    const std::filesystem::path& folder = "/dev/input");

}  // namespace twin::devices
