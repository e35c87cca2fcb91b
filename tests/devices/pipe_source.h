#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <utility>

#include "plugins/devices/event_source.h"
#include "twin/fci/sockets.h"

namespace twin::devices {

/// Six axes of ±350 and two buttons.
inline EvdevCapabilities SpaceMouse() {
  EvdevCapabilities has;
  has.name = "SpaceMouse in a test";
  for (std::uint16_t code = ABS_X; code <= ABS_RZ; ++code) has.abs[code] = {-350, 350, 0};
  has.keys = {BTN_0, BTN_1};
  return has;
}

/// Two sticks, a cross, triggers, the usual buttons.
inline EvdevCapabilities Gamepad() {
  EvdevCapabilities has;
  has.name = "Gamepad in a test";
  for (const std::uint16_t code : {ABS_X, ABS_Y, ABS_RX, ABS_RY}) {
    has.abs[code] = {-32768, 32767, 4096};
  }
  for (const std::uint16_t code : {ABS_Z, ABS_RZ}) has.abs[code] = {0, 1023, 0};
  for (const std::uint16_t code : {ABS_HAT0X, ABS_HAT0Y}) has.abs[code] = {-1, 1, 0};
  has.keys = {BTN_A, BTN_B, BTN_X, BTN_Y, BTN_TL, BTN_TR, BTN_SELECT, BTN_START};
  has.can_rumble = true;
  return has;
}

/// One event as the kernel tells it.
inline input_event Event(unsigned type, unsigned code, int value) {
  input_event event{};
  event.type = static_cast<std::uint16_t>(type);
  event.code = static_cast<std::uint16_t>(code);
  event.value = value;
  return event;
}

/// The end of a pipe into which a test writes a device's events. To close it unplugs the device.
class PipeEnd {
 public:
  explicit PipeEnd(int fd) : fd_(fd) {}
  /// Writes the events, and that they are a whole report.
  void Report(std::initializer_list<input_event> events) {
    for (const input_event& event : events) Write(event);
    Write(Event(EV_SYN, SYN_REPORT, 0));
  }
  void Unplug() { fd_.Reset(); }

 private:
  void Write(const input_event& event) {
    if (::write(fd_.get(), &event, sizeof event) != sizeof event) std::abort();
  }
  fci::FileDescriptor fd_;
};

/// An input device made of a pipe.
class PipeSource final : public EventSource {
 public:
  /// @param rumbled  gets what it was told to rumble with; may be null.
  PipeSource(int fd, EvdevCapabilities capabilities, std::atomic<double>* rumbled = nullptr)
      : fd_(fd), capabilities_(std::move(capabilities)), rumbled_(rumbled) {}

  [[nodiscard]] const EvdevCapabilities& capabilities() const override { return capabilities_; }
  [[nodiscard]] int fd() const override { return fd_.get(); }
  [[nodiscard]] Result Next(input_event& event) override {
    const auto got = ::read(fd_.get(), &event, sizeof event);
    if (got == sizeof event) return Result::kEvent;
    return got < 0 && errno == EAGAIN ? Result::kNone : Result::kGone;
  }
  void Rumble(double strength) override {
    if (rumbled_ != nullptr) *rumbled_ = strength;
  }

 private:
  fci::FileDescriptor fd_;
  EvdevCapabilities capabilities_;
  std::atomic<double>* rumbled_;
};

/// Both ends of a new device.
struct PluggedIn {
  std::unique_ptr<EventSource> source;
  PipeEnd end;
};
inline PluggedIn PlugIn(EvdevCapabilities capabilities, std::atomic<double>* rumbled = nullptr) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_NONBLOCK | O_CLOEXEC) != 0) std::abort();
  return {std::make_unique<PipeSource>(ends[0], std::move(capabilities), rumbled),
          PipeEnd(ends[1])};
}

}  // namespace twin::devices
