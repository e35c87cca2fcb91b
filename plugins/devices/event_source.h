#pragma once

#include <linux/input.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "plugins/devices/evdev_profile.h"

namespace twin::devices {

/// Event source of an input device: an open /dev/input/event*, or its replacement in tests.
/// Threads: one.
class EventSource {
 public:
  enum class Result : std::uint8_t {
    kEvent,
    kNone,  ///< none queued
    kGone,  ///< unplugged
  };
  virtual ~EventSource() = default;

  [[nodiscard]] virtual const EvdevCapabilities& capabilities() const = 0;
  /// Becomes readable when an event arrives.
  [[nodiscard]] virtual int fd() const = 0;
  /// Reads the next queued event; does not block.
  [[nodiscard]] virtual Result Next(input_event& event) = 0;
  /// @param strength  in [0, 1]; lasts one second unless renewed.
  virtual void Rumble(double strength) = 0;
};

/// Opens a device. After an overflow, events for the resulting state replace the lost ones.
/// @throws InputError if `path` does not exist or is not an input device; EnvironmentError with the
/// cure if reading is not permitted.
[[nodiscard]] std::unique_ptr<EventSource> OpenEventSource(const std::filesystem::path& path);

/// An input device of this machine.
struct FoundDevice {
  std::filesystem::path path;
  EvdevCapabilities capabilities;  ///< empty if it could not be opened
  std::string why_not{};           ///< reason; empty if it could be opened
};

/// All devices, by number. @param folder  the folder to search.
[[nodiscard]] std::vector<FoundDevice> FindEventDevices(
    const std::filesystem::path& folder = "/dev/input");

}  // namespace twin::devices
