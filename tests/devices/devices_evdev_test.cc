// The device "evdev" with pipes in place of input devices.

#include <atomic>
#include <memory>
#include <mutex>
#include <utility>

#include <gmock/gmock.h>

#include "devices/pipe_source.h"
#include "plugins/devices/evdev_device.h"
#include "twin/core/error.h"
#include "twin/rt/host_time.h"

namespace twin::devices::devices_evdev_test {
namespace {

using namespace std::chrono_literals;
using teleop::OperatorSample;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// Waits until `happens`, which must.
template <typename Condition>
void Await(Condition happens) {
  for (int i = 0; i < 100'000; ++i) {
    if (happens()) return;
    rt::Pause(1ms);
  }
  FAIL() << "it did not happen";
}

class EvdevDeviceTest : public testing::Test {
 protected:
  explicit EvdevDeviceTest(const EvdevCapabilities& has = SpaceMouse())
      : plugged_(PlugIn(has, &rumble_)),
        device_(clock_, std::move(plugged_.source), [this] { return Again(); },
                {.profile = UsualProfile(*KindOf(has), has), .where = "a pipe"}) {}

  /// What is plugged in again.
  std::unique_ptr<EventSource> Again() {
    const std::scoped_lock lock(mutex_);
    if (!again_) throw InputError("nothing is plugged in");
    return std::move(again_);
  }
  void PlugInAgain(PluggedIn& plugged) {
    const std::scoped_lock lock(mutex_);
    again_ = std::move(plugged.source);
  }
  /// The newest sample, once there is one that fits.
  template <typename Fits>
  OperatorSample AwaitSample(Fits fits) {
    OperatorSample newest;
    Await([&] {
      const auto sample = device_.Read({});
      if (sample) newest = *sample;
      return sample && fits(*sample);
    });
    return newest;
  }

  std::mutex mutex_;
  std::unique_ptr<EventSource> again_;
  MonotonicClock clock_;
  std::atomic<double> rumble_{0};
  PluggedIn plugged_;
  EvdevDevice device_;
};

TEST_F(EvdevDeviceTest, GoesOnTellingWhatIsHeld) {
  plugged_.end.Report({Event(EV_ABS, ABS_Y, -350)});
  const OperatorSample first = AwaitSample([](const auto& s) { return s.axes[0] == 1; });
  const OperatorSample later =
      AwaitSample([&](const auto& s) { return s.sequence >= first.sequence + 3; });
  EXPECT_EQ(later.axes[0], 1);
}

TEST_F(EvdevDeviceTest, IsFoundAgainWithEverythingLetGo) {
  plugged_.end.Report({Event(EV_ABS, ABS_Y, -350), Event(EV_KEY, BTN_0, 1)});
  const OperatorSample before = AwaitSample([](const auto& s) { return s.axes[0] == 1; });
  plugged_.end.Unplug();
  Await([&] { return device_.lost(); });
  static_cast<void>(device_.Read({}));  // one may have been on its way
  PluggedIn again = PlugIn(SpaceMouse());
  PlugInAgain(again);
  Await([&] { return !device_.lost(); });
  const OperatorSample after = AwaitSample([](const auto&) { return true; });
  EXPECT_GT(after.sequence, before.sequence);
  EXPECT_EQ(after.axes, Vector6{});
  EXPECT_EQ(after.gripper_presses, 0u);
}

TEST_F(EvdevDeviceTest, TakesNoOtherDeviceAtItsPlace) {
  plugged_.end.Unplug();
  Await([&] { return device_.lost(); });
  PluggedIn other = PlugIn(Gamepad());
  PlugInAgain(other);
  Await([&] {
    const std::scoped_lock lock(mutex_);
    return again_ == nullptr;
  });
  PluggedIn again = PlugIn(SpaceMouse());
  PlugInAgain(again);
  Await([&] { return !device_.lost(); });
  again.end.Report({Event(EV_ABS, ABS_Y, -350)});
  EXPECT_EQ(AwaitSample([](const auto& s) { return s.axes[0] != 0; }).axes[0], 1);
}

TEST_F(EvdevDeviceTest, KnowsFromTheFeedbackWhatItsButtonsMean) {
  device_.Feel({.sequence = 1, .stopped = true});
  plugged_.end.Report({Event(EV_KEY, BTN_0, 1)});
  EXPECT_EQ(AwaitSample([](const auto& s) { return s.release_presses > 0; }).gripper_presses, 0u);
}

TEST_F(EvdevDeviceTest, SaysItsNameAndPlace) {
  EXPECT_EQ(device_.Describe(), "SpaceMouse in a test at a pipe");
}

class RumbleTest : public EvdevDeviceTest {
 protected:
  RumbleTest() : EvdevDeviceTest(Gamepad()) {}
};

TEST_F(RumbleTest, IsTheForceAsAShareOfFull) {
  device_.Feel({.sequence = 1, .wrench = {3, 0, -4, 9, 9, 9}});  // 5 N of 10
  Await([&] { return rumble_ == 0.5; });
}

TEST_F(RumbleTest, StopsWithTheForce) {
  device_.Feel({.sequence = 1, .wrench = {100, 0, 0, 0, 0, 0}});
  Await([&] { return rumble_ == 1; });
  device_.Feel({.sequence = 2});
  Await([&] { return rumble_ == 0; });
}

TEST(OpenEventSourceTest, RefusesWhatIsNotThere) {
  EXPECT_THAT([] { static_cast<void>(OpenEventSource("/dev/input/there_is_none")); },
              ThrowsMessage<InputError>(HasSubstr("/dev/input/there_is_none: No such file")));
}

TEST(OpenEventSourceTest, RefusesWhatIsNoInputDevice) {
  EXPECT_THAT([] { static_cast<void>(OpenEventSource("/dev/null")); },
              ThrowsMessage<InputError>(HasSubstr("/dev/null: is no input device")));
}

TEST(MakeEvdevDeviceTest, RefusesLockstep) {
  const control::Parameters none;
  control::ParameterReader reader(none);
  const MonotonicClock clock;
  EXPECT_THAT(
      [&] {
        static_cast<void>(MakeEvdevDevice(
            {.parameters = reader, .folder = {}, .clock = clock, .is_lockstep = true}));
      },
      ThrowsMessage<InputError>(HasSubstr("--drive realtime")));
}

}  // namespace
}  // namespace twin::devices::devices_evdev_test
