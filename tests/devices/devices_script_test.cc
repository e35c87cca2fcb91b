#include <bit>
#include <sstream>
#include <string>

#include <gmock/gmock.h>

#include "plugins/devices/script_device.h"
#include "support/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/core/random.h"
#include "twin/teleop/mapping.h"
#include "twin/teleop/operator_ranges.h"
#include "twin/teleop/operator_script.h"

namespace twin::devices::devices_script_test {
namespace {

using namespace std::chrono_literals;
using teleop::OperatorSample;
using testing::HasSubstr;
using testing::ThrowsMessage;

std::vector<OperatorSample> Parse(const std::string& rows) {
  std::istringstream in(teleop::OperatorScriptHeader() + rows);
  return teleop::ReadOperatorScript(in, "hands.csv");
}

void ExpectRefused(const std::string& rows, const std::string& text) {
  EXPECT_THAT([&] { Parse(rows); }, ThrowsMessage<InputError>(HasSubstr(text))) << rows;
}

constexpr const char* kRest = "0,rate,0,0,0,0,0,0,1,0,0,0,0,0,0,0\n";

TEST(OperatorScriptTest, ReadsEveryColumn) {
  const auto samples = Parse("0.25,pose,1,2,3,-4,-5,-6,0,1,2,3,4,5,6,7\n");
  ASSERT_EQ(samples.size(), 1u);
  const OperatorSample& sample = samples[0];
  EXPECT_EQ(sample.sequence, 1u);
  EXPECT_EQ(sample.at, Time(250ms));
  EXPECT_EQ(sample.kind, teleop::AxisKind::kPose);
  EXPECT_EQ(sample.axes, (Vector6{1, 2, 3, -4, -5, -6}));
  EXPECT_FALSE(sample.engaged);
  EXPECT_EQ(sample.mode_presses, 1u);
  EXPECT_EQ(sample.gripper_presses, 2u);
  EXPECT_EQ(sample.frame_presses, 3u);
  EXPECT_EQ(sample.scale_presses, 4u);
  EXPECT_EQ(sample.stop_presses, 5u);
  EXPECT_EQ(sample.release_presses, 6u);
  EXPECT_EQ(sample.end_presses, 7u);
}

TEST(OperatorScriptTest, SumsPressesUp) {
  const auto samples = Parse(std::string(kRest) + "1,rate,0,0,0,0,0,0,1,0,2,0,0,0,0,0\n" +
                             "2,rate,0,0,0,0,0,0,1,0,1,0,0,0,0,0\n");
  EXPECT_EQ(samples[1].gripper_presses, 2u);
  EXPECT_EQ(samples[2].gripper_presses, 3u);
}

TEST(OperatorScriptTest, RefusesTimesThatDoNotRise) {
  ExpectRefused(std::string(kRest) + kRest,
                "hands.csv:3: column time is '0'; it must be later than that of the line before");
}

TEST(OperatorScriptTest, RefusesTimesOutOfRange) {
  ExpectRefused("-1,rate,0,0,0,0,0,0,1,0,0,0,0,0,0,0\n", "it must lie in [0, 86400] seconds");
}

TEST(OperatorScriptTest, RefusesKindsThatAreNone) {
  ExpectRefused("0,speed,0,0,0,0,0,0,1,0,0,0,0,0,0,0\n",
                "hands.csv:2: column kind is 'speed'; it must be rate, pose or joint1 to joint7");
}

TEST(OperatorScriptTest, RefusesDeflectionsBeyondFullScale) {
  ExpectRefused("0,rate,0,0,1.01,0,0,0,1,0,0,0,0,0,0,0\n",
                "hands.csv:2: column z is '1.01'; it must lie in [-1, 1] of full scale");
}

TEST(OperatorScriptTest, RefusesWhatIsNoNumber) {
  ExpectRefused("0,rate,0,0,nan,0,0,0,1,0,0,0,0,0,0,0\n", "column z is 'nan'");
}

TEST(OperatorScriptTest, RefusesFlagsThatAreNone) {
  ExpectRefused("0,rate,0,0,0,0,0,0,yes,0,0,0,0,0,0,0\n",
                "column engaged is 'yes'; it must be 1 or 0");
}

TEST(OperatorScriptTest, RefusesPartsOfAPress) {
  ExpectRefused("0,rate,0,0,0,0,0,0,1,0,0.5,0,0,0,0,0\n",
                "column gripper is '0.5'; it must be a whole number");
}

TEST(OperatorScriptTest, RefusesMorePressesThanACounterHolds) {
  ExpectRefused("0,rate,0,0,0,0,0,0,1,0,4294967295,0,0,0,0,0\n1,rate,0,0,0,0,0,0,1,0,1,0,0,0,0,0\n",
                "hands.csv:3: column gripper is '1'; with those of the lines before");
}

TEST(OperatorScriptTest, RefusesAFileWithoutSamples) {
  ExpectRefused("", "hands.csv: no samples; wanted is the header 'time,kind,x");
}

TEST(OperatorScriptTest, RefusesAFileThatIsNotThere) {
  EXPECT_THAT([] { static_cast<void>(teleop::ReadOperatorScript("there/is/none.csv")); },
              ThrowsMessage<InputError>(HasSubstr("there/is/none.csv: not a file")));
}

/// A sample with any values that are sound.
OperatorSample Any(const Random& random, std::uint64_t n) {
  const auto bits = random.Bits(n);
  OperatorSample sample;
  sample.sequence = n + 1;
  sample.at = Time(Duration(static_cast<std::int64_t>(n * 1'000'000'007 + bits[0] % 1000)));
  sample.kind = bits[1] % 2 == 0 ? teleop::AxisKind::kRate : teleop::AxisKind::kPose;
  if (sample.kind == teleop::AxisKind::kRate) sample.joint = static_cast<std::uint8_t>(n % 8);
  for (std::size_t i = 0; i < sample.axes.size(); ++i) {
    sample.axes[i] = 2 * random.Uniform(1000 + n, static_cast<std::uint32_t>(i)) - 1;
  }
  sample.engaged = bits[2] % 2 == 0;
  for (const auto presses : teleop::kPresses) sample.*presses = static_cast<std::uint32_t>(n);
  return sample;
}

TEST(OperatorScriptTest, ReadsTheSameBitsThatItWrote) {
  const Random random(11, RandomStream::kTest);
  std::string rows;
  OperatorSample before;
  for (std::uint64_t n = 0; n < 500; ++n) {
    const OperatorSample sample = Any(random, n);
    rows += teleop::OperatorScriptRow(sample, before);
    before = sample;
  }
  const auto samples = Parse(rows);
  ASSERT_EQ(samples.size(), 500u);
  for (std::uint64_t n = 0; n < 500; ++n) {
    const OperatorSample wanted = Any(random, n);
    EXPECT_EQ(samples[n].at, wanted.at);
    EXPECT_EQ(samples[n].kind, wanted.kind);
    EXPECT_EQ(samples[n].joint, wanted.joint);
    EXPECT_EQ((std::bit_cast<std::array<std::uint64_t, 6>>(samples[n].axes)),
              (std::bit_cast<std::array<std::uint64_t, 6>>(wanted.axes)));
    EXPECT_EQ(samples[n].engaged, wanted.engaged);
    for (const auto presses : teleop::kPresses) EXPECT_EQ(samples[n].*presses, wanted.*presses);
  }
}

class ScriptDeviceTest : public testing::Test {
 protected:
  /// Samples at 0, 10 and 20 ms, with one press of the gripper more in each.
  static std::vector<OperatorSample> Samples() {
    return Parse(
        "0,rate,0.1,0,0,0,0,0,1,0,0,0,0,0,0,0\n"
        "0.01,rate,0.2,0,0,0,0,0,1,0,1,0,0,0,0,0\n"
        "0.02,rate,0.3,0,0,0,0,0,1,0,1,0,0,0,0,0\n");
  }
  static ScriptDevice Device(const ScriptSettings& settings) {
    return {Samples(), "hands.csv", settings};
  }
};

TEST_F(ScriptDeviceTest, CountsTimeFromTheFirstRead) {
  ScriptDevice device = Device({});
  EXPECT_EQ(device.Read(Time(5s))->axes[0], 0.1);
  EXPECT_FALSE(device.Read(Time(5s + 9ms)).has_value());
  EXPECT_EQ(device.Read(Time(5s + 10ms))->axes[0], 0.2);
}

TEST_F(ScriptDeviceTest, GivesTheNewestOfSeveralWithAllTheirPresses) {
  ScriptDevice device = Device({});
  static_cast<void>(device.Read(Time(0s)));
  const auto sample = device.Read(Time(50ms));
  EXPECT_EQ(sample->axes[0], 0.3);
  EXPECT_EQ(sample->gripper_presses, 2u);
}

TEST_F(ScriptDeviceTest, PressesTheEndAfterTheLastRow) {
  ScriptDevice device = Device({});
  static_cast<void>(device.Read(Time(0s)));
  static_cast<void>(device.Read(Time(20ms)));
  EXPECT_FALSE(device.Read(Time(119ms)).has_value());
  const auto end = device.Read(Time(120ms));
  EXPECT_EQ(end->end_presses, 1u);
  EXPECT_EQ(end->axes, Vector6{});
}

TEST_F(ScriptDeviceTest, IsLostAfterItsEnd) {
  ScriptDevice device = Device({});
  static_cast<void>(device.Read(Time(0s)));
  static_cast<void>(device.Read(Time(120ms)));
  static_cast<void>(device.Read(Time(120ms + ScriptDevice::kEndLasts)));
  EXPECT_FALSE(device.lost());
  static_cast<void>(device.Read(Time(121ms + ScriptDevice::kEndLasts)));
  EXPECT_TRUE(device.lost());
}

TEST_F(ScriptDeviceTest, TellsItsEndAgainForSecondsAsAWireMayLoseIt) {
  ScriptDevice device = Device({});
  static_cast<void>(device.Read(Time(0s)));
  std::uint64_t before = device.Read(Time(120ms))->sequence;
  int told = 0;
  for (int ms = 121; ms < 3120; ++ms) {
    const auto sample = device.Read(Time(ms * 1ms));
    if (!sample) continue;
    ++told;
    EXPECT_EQ(sample->end_presses, 1u);
    EXPECT_GT(sample->sequence, before);
    before = sample->sequence;
  }
  EXPECT_GE(told, 80);
}

TEST_F(ScriptDeviceTest, PressesInItsFirstRowThoughHalfOfTheSamplesAreLost) {
  ScriptDevice device(Parse("0,rate,0.3,0,0,0,0,0,1,1,0,0,0,0,0,0\n"
                            "0.5,rate,0.3,0,0,0,0,0,1,0,0,0,0,0,0,1\n"),
                      "hands.csv", {});
  teleop::Mapping mapping({}, {.along = 1, .about = 1, .ahead = 1, .turning = 1});
  mapping.Begin(true);
  int given = 0;
  for (int ms = 0; ms < 1000 && !mapping.ends(); ++ms) {
    const auto sample = device.Read(Time(ms * 1ms));
    if (sample && given++ % 2 == 1) {
      static_cast<void>(mapping.Update(*sample, {.connected = true}));
    }
  }
  EXPECT_TRUE(mapping.ends());
  EXPECT_EQ(mapping.mode(), teleop::Mode::kBase);
}

TEST_F(ScriptDeviceTest, LeavesTheEndOutWhereItIsToBeLost) {
  ScriptDevice device = Device({.repeat = {}, .ends = false});
  static_cast<void>(device.Read(Time(0s)));
  EXPECT_EQ(device.Read(Time(20ms))->end_presses, 0u);
  EXPECT_FALSE(device.Read(Time(1s)).has_value());
  EXPECT_TRUE(device.lost());
}

TEST_F(ScriptDeviceTest, RepeatsTheNewestWhenNothingElseComes) {
  ScriptDevice device = Device({.repeat = 4ms, .ends = false});
  static_cast<void>(device.Read(Time(0s)));
  EXPECT_FALSE(device.Read(Time(3ms)).has_value());
  const auto again = device.Read(Time(4ms));
  EXPECT_EQ(again->axes[0], 0.1);
  EXPECT_EQ(again->sequence, 2u);
}

TEST_F(ScriptDeviceTest, GivesTheSameForTheSameTimes) {
  ScriptDevice one = Device({.repeat = 3ms, .ends = true});
  ScriptDevice other = Device({.repeat = 3ms, .ends = true});
  for (int ms = 0; ms < 200; ++ms) {
    const auto a = one.Read(Time(ms * 1ms));
    const auto b = other.Read(Time(ms * 1ms));
    ASSERT_EQ(a.has_value(), b.has_value());
    if (a) {
      EXPECT_EQ(teleop::OperatorScriptRow(*a, {}), teleop::OperatorScriptRow(*b, {}));
    }
  }
}

TEST(MakeScriptDeviceTest, FindsTheFileBesideTheScenario) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "hands.csv") << teleop::OperatorScriptHeader() << kRest;
  const control::Parameters parameters{{.key = "file", .values = {"hands.csv"}}};
  control::ParameterReader reader(parameters);
  const MonotonicClock clock;
  const auto device =
      MakeScriptDevice({.parameters = reader, .folder = folder.path(), .clock = clock});
  EXPECT_THAT(device->Describe(), HasSubstr("hands.csv"));
}

TEST(MakeScriptDeviceTest, AsksForItsFile) {
  const control::Parameters none;
  control::ParameterReader reader(none, "operator.device");
  const MonotonicClock clock;
  EXPECT_THAT(
      [&] {
        static_cast<void>(MakeScriptDevice({.parameters = reader, .folder = {}, .clock = clock}));
      },
      ThrowsMessage<InputError>(HasSubstr("operator.device.file: is missing")));
}

}  // namespace
}  // namespace twin::devices::devices_script_test
