#include <sys/resource.h>

#include <csignal>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "plugins/devices/script_device.h"
#include "support/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/teleop/operator_script.h"
#include "twin/teleop/recording_device.h"

namespace twin::devices::devices_recording_test {
namespace {

using namespace std::chrono_literals;
using teleop::OperatorSample;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// Gives a sample with every call, the n-th with sequence n.
class EveryCall final : public teleop::Device {
 public:
  std::optional<OperatorSample> Read(Time now) noexcept override {
    ++sample_.sequence;
    sample_.at = now;
    sample_.axes[0] = 1.0 / static_cast<double>(sample_.sequence);
    if (sample_.sequence % 10 == 0) ++sample_.mode_presses;
    return sample_;
  }
  void Feel(const teleop::OperatorFeedback&) noexcept override {}
  bool lost() const noexcept override { return false; }
  std::string Describe() const override { return "a test"; }

 private:
  OperatorSample sample_;
};

class RecordingDeviceTest : public testing::Test {
 protected:
  std::filesystem::path path() const { return folder_ / "session.csv"; }
  std::filesystem::path partial() const { return folder_ / "session.csv.partial"; }
  test::TemporaryFolder folder_;
};

TEST_F(RecordingDeviceTest, KeepsWhatRunsAgainAsItWas) {
  std::vector<OperatorSample> given;
  {
    teleop::RecordingDevice device(std::make_unique<EveryCall>(), path(), {});
    for (int ms = 0; ms < 500; ++ms) given.push_back(*device.Read(Time(3s + ms * 1ms)));
    device.Finish();
  }
  ScriptDevice again(teleop::ReadOperatorScript(path()), "again", {.repeat = {}, .ends = false});
  for (int ms = 0; ms < 500; ++ms) {
    const auto sample = again.Read(Time(8s + ms * 1ms));
    ASSERT_TRUE(sample.has_value());
    const OperatorSample& wanted = given[static_cast<std::size_t>(ms)];
    EXPECT_EQ(sample->sequence, wanted.sequence);
    EXPECT_EQ(sample->axes, wanted.axes);
    EXPECT_EQ(sample->mode_presses, wanted.mode_presses);
  }
}

/// Gives what it is told to, at every call.
class Given final : public teleop::Device {
 public:
  explicit Given(const OperatorSample& sample) : sample_(sample) {}
  std::optional<OperatorSample> Read(Time) noexcept override { return sample_; }
  void Feel(const teleop::OperatorFeedback&) noexcept override {}
  bool lost() const noexcept override { return false; }
  std::string Describe() const override { return "a test"; }

 private:
  const OperatorSample& sample_;
};

TEST_F(RecordingDeviceTest, PressesNothingWhenACounterFalls) {
  OperatorSample sample{.sequence = 1, .gripper_presses = 5};
  {
    teleop::RecordingDevice device(std::make_unique<Given>(sample), path(), {}, sample);
    static_cast<void>(device.Read(Time(0ms)));
    sample.gripper_presses = 0;
    static_cast<void>(device.Read(Time(1ms)));
    sample.gripper_presses = 2;
    static_cast<void>(device.Read(Time(2ms)));
  }
  const auto samples = teleop::ReadOperatorScript(path());
  ASSERT_EQ(samples.size(), 3u);
  EXPECT_EQ(samples[0].gripper_presses, 0u);
  EXPECT_EQ(samples[1].gripper_presses, 0u);
  EXPECT_EQ(samples[2].gripper_presses, 2u);
}

TEST_F(RecordingDeviceTest, BeginsInTheModeAndScaleInWhichThingsAre) {
  OperatorSample sample{.sequence = 1, .mode_presses = 3, .scale_presses = 1};
  {
    teleop::RecordingDevice device(std::make_unique<Given>(sample), path(), {}, sample);
    device.Feel({.mode = teleop::Mode::kBase, .fine = true});
    static_cast<void>(device.Read(Time(0ms)));
    device.Feel({.mode = teleop::Mode::kArm});
    ++sample.mode_presses;
    static_cast<void>(device.Read(Time(1ms)));
  }
  const auto samples = teleop::ReadOperatorScript(path());
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples[0].mode_presses, 1u);
  EXPECT_EQ(samples[0].scale_presses, 1u);
  EXPECT_EQ(samples[1].mode_presses, 2u);
}

TEST_F(RecordingDeviceTest, KeepsThePressesOfItsFirstSample) {
  const OperatorSample before{.sequence = 1, .gripper_presses = 5};
  const OperatorSample sample{.sequence = 2, .gripper_presses = 6};
  {
    teleop::RecordingDevice device(std::make_unique<Given>(sample), path(), {}, before);
    static_cast<void>(device.Read(Time(0ms)));
  }
  EXPECT_EQ(teleop::ReadOperatorScript(path())[0].gripper_presses, 1u);
}

TEST_F(RecordingDeviceTest, IsPartialUntilItIsWhole) {
  teleop::RecordingDevice device(std::make_unique<EveryCall>(), path(), {});
  static_cast<void>(device.Read(Time(0s)));
  EXPECT_FALSE(std::filesystem::exists(path()));
  EXPECT_TRUE(std::filesystem::exists(partial()));
  device.Finish();
  EXPECT_TRUE(std::filesystem::exists(path()));
  EXPECT_FALSE(std::filesystem::exists(partial()));
}

TEST_F(RecordingDeviceTest, IsWholeOnceTheDeviceHasGone) {
  {
    teleop::RecordingDevice device(std::make_unique<EveryCall>(), path(), {});
    static_cast<void>(device.Read(Time(0s)));
  }
  EXPECT_EQ(teleop::ReadOperatorScript(path()).size(), 1u);
}

TEST_F(RecordingDeviceTest, GivesTwoReadsAtOneInstantRowsOfTheirOwn) {
  {
    teleop::RecordingDevice device(std::make_unique<EveryCall>(), path(), {});
    static_cast<void>(device.Read(Time(1s)));
    static_cast<void>(device.Read(Time(1s)));
  }
  EXPECT_EQ(teleop::ReadOperatorScript(path()).size(), 2u);
}

TEST_F(RecordingDeviceTest, ReplacesNoRecording) {
  std::ofstream(path()) << "mine";
  EXPECT_THAT([&] { teleop::RecordingDevice(std::make_unique<EveryCall>(), path(), {}); },
              ThrowsMessage<InputError>(HasSubstr("a recording is not replaced")));
  EXPECT_EQ(test::ReadText(path()), "mine");
}

TEST_F(RecordingDeviceTest, TellsWhenSamplesAreMissing) {
  std::string told;
  {
    // Two fit, and the disk is looked after every 20 ms.
    teleop::RecordingDevice device(
        std::make_unique<EveryCall>(), path(), [&](std::string_view text) { told = text; }, {}, 2);
    for (int i = 0; i < 10'000; ++i) static_cast<void>(device.Read(Time(i * 1us)));
  }
  EXPECT_THAT(told, HasSubstr("samples are missing"));
  EXPECT_FALSE(std::filesystem::exists(path()));
}

TEST_F(RecordingDeviceTest, TellsWhenTheDiskIsFull) {
  std::string told;
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, SIG_IGN);
  {
    teleop::RecordingDevice device(std::make_unique<EveryCall>(), path(),
                                   [&](std::string_view text) { told = text; });
    const rlimit small{.rlim_cur = 1000, .rlim_max = before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    for (int i = 0; i < 1000; ++i) static_cast<void>(device.Read(Time(i * 1us)));
  }
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  EXPECT_THAT(told, HasSubstr("cannot write"));
  EXPECT_FALSE(std::filesystem::exists(path()));
}

TEST_F(RecordingDeviceTest, RefusesAFolderThatIsNotThere) {
  EXPECT_THROW(
      teleop::RecordingDevice(std::make_unique<EveryCall>(), folder_ / "none/session.csv", {}),
      EnvironmentError);
}

}  // namespace
}  // namespace twin::devices::devices_recording_test
