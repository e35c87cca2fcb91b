#include "plugins/devices/event_source.h"

#include <fcntl.h>
#include <libevdev/libevdev.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/integer.h"
#include "twin/fci/sockets.h"

namespace twin::devices {
namespace {

struct FreeEvdev {
  void operator()(libevdev* device) const { libevdev_free(device); }
};
using Evdev = std::unique_ptr<libevdev, FreeEvdev>;

std::string Reason(int error) {
  return std::generic_category().message(error);
}

/// Opens for writing too, if permitted: rumble requires it.
fci::FileDescriptor Open(const std::filesystem::path& path) {
  int fd = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0 && (errno == EACCES || errno == EPERM || errno == EROFS)) {
    fd = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  }
  if (fd >= 0) return fci::FileDescriptor(fd);
  const int error = errno;
  if (error == EACCES || error == EPERM) {
    throw EnvironmentError(fmt::format(
        "{}: permission denied; input devices are readable to the group input: add yourself (sudo "
        "usermod -aG input $USER) and log in again",
        path.string()));
  }
  throw InputError(fmt::format("{}: {}; panda-twin devices lists the input devices there are",
                               path.string(), Reason(error)));
}

Evdev Attach(int fd, const std::filesystem::path& path) {
  libevdev* device = nullptr;
  const int result = libevdev_new_from_fd(fd, &device);
  if (result == 0) return Evdev(device);
  throw InputError(fmt::format("{}: is no input device ({})", path.string(), Reason(-result)));
}

EvdevCapabilities Ask(libevdev* device) {
  EvdevCapabilities has;
  has.name = libevdev_get_name(device);
  const auto knows = [device](unsigned type, unsigned code) {
    return libevdev_has_event_code(device, type, code) == 1;
  };
  for (std::uint16_t code = 0; code < ABS_CNT; ++code) {
    const input_absinfo* info = libevdev_get_abs_info(device, code);
    if (info != nullptr) has.abs[code] = {info->minimum, info->maximum, info->flat};
  }
  for (std::uint16_t code = 0; code < REL_CNT; ++code) {
    if (knows(EV_REL, code)) has.rel.insert(code);
  }
  for (std::uint16_t code = 0; code < KEY_CNT; ++code) {
    if (knows(EV_KEY, code)) has.keys.insert(code);
  }
  has.can_rumble = knows(EV_FF, FF_RUMBLE);
  return has;
}

class LibevdevSource final : public EventSource {
 public:
  explicit LibevdevSource(const std::filesystem::path& path)
      : fd_(Open(path)), device_(Attach(fd_.get(), path)), capabilities_(Ask(device_.get())) {}

  [[nodiscard]] const EvdevCapabilities& capabilities() const override { return capabilities_; }
  [[nodiscard]] int fd() const override { return fd_.get(); }
  [[nodiscard]] Result Next(input_event& event) override;
  void Rumble(double strength) override;

 private:
  void Play(int value) const;

  fci::FileDescriptor fd_;
  Evdev device_;
  EvdevCapabilities capabilities_;
  int effect_ = -1;        ///< the kernel's number of it; negative: none yet
  bool is_synced_ = true;  ///< false: events were lost and are being replaced
};

EventSource::Result LibevdevSource::Next(input_event& event) {
  for (;;) {
    const int result = libevdev_next_event(
        device_.get(), is_synced_ ? LIBEVDEV_READ_FLAG_NORMAL : LIBEVDEV_READ_FLAG_SYNC, &event);
    if (result == LIBEVDEV_READ_STATUS_SUCCESS) return Result::kEvent;
    if (result == LIBEVDEV_READ_STATUS_SYNC) {  // SYN_DROPPED, or what it leads to
      is_synced_ = false;
      if (event.type == EV_SYN && event.code == SYN_DROPPED) continue;
      return Result::kEvent;
    }
    if (result == -EINTR) continue;
    if (result != -EAGAIN) return Result::kGone;
    if (is_synced_) return Result::kNone;
    is_synced_ = true;  // all lost events have been replaced
  }
}

void LibevdevSource::Play(int value) const {
  input_event event{};
  event.type = EV_FF;
  event.code = static_cast<std::uint16_t>(effect_);
  event.value = value;
  // Failing to rumble does not fail the session.
  static_cast<void>(!::write(fd_.get(), &event, sizeof event));
}

void LibevdevSource::Rumble(double strength) {
  if (!capabilities_.can_rumble) return;
  ff_effect effect{};
  effect.type = FF_RUMBLE;
  effect.id = static_cast<std::int16_t>(effect_);
  effect.u.rumble.strong_magnitude = static_cast<std::uint16_t>(std::lround(strength * 0xFFFF));
  effect.u.rumble.weak_magnitude = effect.u.rumble.strong_magnitude / 2;
  effect.replay.length = 1000;  // ms
  if (::ioctl(fd_.get(), EVIOCSFF, &effect) < 0) {
    capabilities_.can_rumble = false;
    return;
  }
  effect_ = effect.id;
  Play(strength > 0 ? 1 : 0);
}

/// The number after "event"; negative for other names.
int NumberOf(const std::filesystem::path& path) {
  constexpr std::string_view kPrefix = "event";
  const std::string name = path.filename().string();
  if (!name.starts_with(kPrefix)) return -1;
  return ParseInteger<int>(std::string_view(name).substr(kPrefix.size())).value_or(-1);
}

}  // namespace

std::unique_ptr<EventSource> OpenEventSource(const std::filesystem::path& path) {
  return std::make_unique<LibevdevSource>(path);
}

std::vector<FoundDevice> FindEventDevices(const std::filesystem::path& folder) {
  std::vector<FoundDevice> found;
  std::error_code none;  // a missing folder has no devices
  for (const auto& entry : std::filesystem::directory_iterator(folder, none)) {
    if (NumberOf(entry.path()) < 0) continue;
    FoundDevice device{entry.path(), {}, {}};
    try {
      device.capabilities = OpenEventSource(entry.path())->capabilities();
    } catch (const Error& error) {
      device.why_not = error.what();
    }
    found.push_back(std::move(device));
  }
  std::ranges::sort(found, {}, [](const FoundDevice& device) { return NumberOf(device.path); });
  return found;
}

}  // namespace twin::devices
