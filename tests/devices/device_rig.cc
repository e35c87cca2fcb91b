#include "devices/device_rig.h"

#include <stdexcept>
#include <utility>
#include <vector>

#include "devices/pipe_source.h"
#include "plugins/devices/evdev_device.h"
#include "plugins/devices/network_device.h"
#include "plugins/devices/script_device.h"
#include "support/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/rt/host_time.h"
#include "twin/teleop/recording_device.h"

namespace twin::devices {
namespace {

using teleop::Device;
using teleop::OperatorSample;

class EvdevRig final : public DeviceRig {
 public:
  Device& device() override { return device_; }
  void Act() override {
    plugged_.end.Report({Event(EV_ABS, ABS_Y, -175), Event(EV_KEY, BTN_0, 1)});
    plugged_.end.Report({Event(EV_KEY, BTN_0, 0)});
  }
  void Go() override { plugged_.end.Unplug(); }

 private:
  MonotonicClock clock_;
  PluggedIn plugged_ = PlugIn(SpaceMouse());
  EvdevDevice device_{clock_,
                      std::move(plugged_.source),
                      []() -> std::unique_ptr<EventSource> { throw InputError("is gone"); },
                      {.profile = UsualProfile(EvdevKind::kSpaceMouse, SpaceMouse())}};
};

class NetworkRig final : public DeviceRig {
 public:
  NetworkRig() { Send(); }
  Device& device() override { return device_; }
  void Act() override {
    message_.sample.axes[0] = 0.5;
    ++message_.sample.gripper_presses;
    Send();
  }
  void Go() override {
    const Time at = Time(std::chrono::hours(1));  // nobody has said anything for so long
    static_cast<void>(device_.Read(at));
  }

 private:
  void Send() {
    ++message_.sample.sequence;
    std::array<std::byte, kSampleBytes> bytes;
    WriteSample(message_, bytes);
    if (!socket_.Send(bytes, device_.local())) std::abort();
  }
  MonotonicClock clock_;
  NetworkDevice device_{clock_, {.bind = {0x7F000001, 0}, .token = *TokenOf("secret")}};
  fci::UdpSocket socket_{clock_, {0x7F000001, 0}};
  SampleMessage message_{.token = *TokenOf("secret"), .sample = {}};
};

std::vector<OperatorSample> Script() {
  OperatorSample rest;
  rest.at = Time(std::chrono::milliseconds(1));
  OperatorSample act = rest;
  act.at = Time(std::chrono::milliseconds(5));
  act.axes[0] = 0.5;
  act.gripper_presses = 1;
  return {rest, act};
}

class ScriptRig final : public DeviceRig {
 public:
  Device& device() override { return device_; }
  void Act() override {}  // it is written in the script
  void Go() override {}   // it ends by itself

 private:
  ScriptDevice device_{Script(), "a test", {.ends = false}};
};

class RecordedRig final : public DeviceRig {
 public:
  Device& device() override { return device_; }
  void Act() override {}
  void Go() override {}

 private:
  twin::test::TemporaryFolder folder_;
  teleop::RecordingDevice device_{
      std::make_unique<ScriptDevice>(Script(), "a test",
                                     ScriptSettings{.repeat = {}, .ends = false}),
      folder_ / "session.csv",
      {}};
};

/// How often something is waited for that must come: minutes, on the slowest machine.
constexpr int kTries = 100'000;

}  // namespace

OperatorSample DeviceRig::Await() {
  for (int i = 0; i < kTries; ++i) {
    if (const auto sample = Read()) return *sample;
    rt::Pause(kCycle);
  }
  throw std::runtime_error("no sample came");
}

OperatorSample DeviceRig::AwaitPresses(std::uint32_t gripper_presses) {
  for (int i = 0; i < kTries; ++i) {
    const OperatorSample sample = Await();
    if (sample.gripper_presses == gripper_presses) return sample;
  }
  throw std::runtime_error("no such sample came");
}

void DeviceRig::AwaitLoss() {
  for (int i = 0; i < kTries; ++i) {
    if (device().lost()) return;
    static_cast<void>(Read());
    rt::Pause(kCycle);
  }
  throw std::runtime_error("it was not lost");
}

std::unique_ptr<DeviceRig> MakeEvdevRig() {
  return std::make_unique<EvdevRig>();
}
std::unique_ptr<DeviceRig> MakeNetworkRig() {
  return std::make_unique<NetworkRig>();
}
std::unique_ptr<DeviceRig> MakeScriptRig() {
  return std::make_unique<ScriptRig>();
}
std::unique_ptr<DeviceRig> MakeRecordedRig() {
  return std::make_unique<RecordedRig>();
}

}  // namespace twin::devices
