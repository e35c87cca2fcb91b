// The device "network" over sockets of this machine. A datagram to one's own machine is there once
// it is sent, and the run's time is what the test says: nothing here waits.

#include <array>
#include <limits>
#include <string>

#include <gmock/gmock.h>

#include "plugins/devices/network_device.h"
#include "twin/core/error.h"

namespace twin::devices::devices_network_test {
namespace {

using namespace std::chrono_literals;
using teleop::OperatorSample;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr std::uint32_t kHere = 0x7F000001;

/// A device's own program.
class Program {
 public:
  Program(const MonotonicClock& clock, const fci::Endpoint& device)
      : socket_(clock, {kHere, 0}), device_(device) {}

  void Send(std::uint64_t sequence, std::uint32_t presses = 0, std::string_view token = "secret") {
    SampleMessage message{.token = *TokenOf(token), .sample = {}};
    message.sample.sequence = sequence;
    message.sample.gripper_presses = presses;
    std::array<std::byte, kSampleBytes> bytes;
    WriteSample(message, bytes);
    SendBytes(bytes);
  }
  void SendBytes(std::span<const std::byte> bytes) { ASSERT_TRUE(socket_.Send(bytes, device_)); }

  std::optional<teleop::OperatorFeedback> Receive() {
    std::array<std::byte, 200> room;
    const auto datagram = socket_.Receive(room);
    if (!datagram) return {};
    return ParseFeedback(datagram->bytes);
  }

 private:
  fci::UdpSocket socket_;
  fci::Endpoint device_;
};

class NetworkDeviceTest : public testing::Test {
 protected:
  static NetworkSettings Settings() {
    return {.bind = {kHere, 0}, .allow = {}, .token = *TokenOf("secret")};
  }
  /// The sequence that is read at an instant; 0: none.
  std::uint64_t SequenceAt(Duration at) {
    const auto sample = device_.Read(Time(at));
    return sample ? sample->sequence : 0;
  }

  MonotonicClock clock_;
  NetworkDevice device_{clock_, Settings()};
  Program program_{clock_, device_.local()};
  Program other_{clock_, device_.local()};
};

TEST_F(NetworkDeviceTest, GivesTheNewestOfThoseThatCame) {
  for (std::uint64_t sequence = 1; sequence <= 3; ++sequence) program_.Send(sequence);
  EXPECT_EQ(SequenceAt(0ms), 3u);
  EXPECT_EQ(SequenceAt(1ms), 0u);
}

TEST_F(NetworkDeviceTest, DropsWhatWasOvertaken) {
  program_.Send(1);
  program_.Send(3);
  program_.Send(2);
  program_.Send(3);
  EXPECT_EQ(SequenceAt(0ms), 3u);
  EXPECT_EQ(device_.tally(), (NetworkDevice::Tally{.taken = 2, .overtaken = 2}));
}

TEST_F(NetworkDeviceTest, MissesNoPressOfSamplesThatWereLost) {
  program_.Send(1, 0);
  static_cast<void>(device_.Read(Time(0ms)));
  program_.Send(9, 3);
  EXPECT_EQ(device_.Read(Time(1ms))->gripper_presses, 3u);
}

TEST_F(NetworkDeviceTest, PassesOverAWrongToken) {
  program_.Send(1, 0, "Secret");
  EXPECT_EQ(SequenceAt(0ms), 0u);
  EXPECT_EQ(device_.tally(), (NetworkDevice::Tally{.wrong_token = 1}));
}

TEST_F(NetworkDeviceTest, PassesOverWhatIsNoSample) {
  program_.SendBytes({});
  program_.SendBytes(std::array<std::byte, kSampleBytes>{});
  program_.SendBytes(std::array<std::byte, 1400>{});
  EXPECT_EQ(SequenceAt(0ms), 0u);
  EXPECT_EQ(device_.tally(), (NetworkDevice::Tally{.malformed = 3}));
}

TEST_F(NetworkDeviceTest, HearsNobodyElseDuringASession) {
  program_.Send(1);
  EXPECT_EQ(SequenceAt(0ms), 1u);
  other_.Send(100);
  EXPECT_EQ(SequenceAt(900ms), 0u);
  EXPECT_EQ(device_.tally(), (NetworkDevice::Tally{.taken = 1, .foreign = 1}));
}

TEST_F(NetworkDeviceTest, IsLostOnceItsSenderIsSilent) {
  program_.Send(1);
  static_cast<void>(device_.Read(Time(0ms)));
  static_cast<void>(device_.Read(Time(1000ms)));
  EXPECT_FALSE(device_.lost());
  static_cast<void>(device_.Read(Time(1001ms)));
  EXPECT_TRUE(device_.lost());
}

TEST_F(NetworkDeviceTest, IsNotKeptAliveByOldSamples) {
  program_.Send(5);
  static_cast<void>(device_.Read(Time(0ms)));
  program_.Send(4);
  static_cast<void>(device_.Read(Time(900ms)));
  static_cast<void>(device_.Read(Time(1001ms)));
  EXPECT_TRUE(device_.lost());
}

TEST_F(NetworkDeviceTest, HearsTheNextSenderAfterTheSilence) {
  program_.Send(1);
  static_cast<void>(device_.Read(Time(0ms)));
  static_cast<void>(device_.Read(Time(2s)));
  other_.Send(1);
  EXPECT_EQ(SequenceAt(2001ms), 2u);
  EXPECT_FALSE(device_.lost());
}

TEST_F(NetworkDeviceTest, PressesNothingWhenAnotherTakesOver) {
  program_.Send(1, 0);
  program_.Send(2, 7);
  EXPECT_EQ(device_.Read(Time(0ms))->gripper_presses, 7u);
  static_cast<void>(device_.Read(Time(2s)));
  other_.Send(50, 1000);
  EXPECT_EQ(device_.Read(Time(2001ms))->gripper_presses, 7u);
  other_.Send(51, 1001);
  EXPECT_EQ(device_.Read(Time(2002ms))->gripper_presses, 8u);
}

TEST_F(NetworkDeviceTest, PressesNothingWhenItsProgramCountsAnew) {
  program_.Send(1, 5);
  static_cast<void>(device_.Read(Time(0ms)));
  program_.Send(2, 7);
  EXPECT_EQ(device_.Read(Time(1ms))->gripper_presses, 2u);
  program_.Send(3, 0);
  EXPECT_EQ(device_.Read(Time(2ms))->gripper_presses, 2u);
  program_.Send(4, 1);
  EXPECT_EQ(device_.Read(Time(3ms))->gripper_presses, 3u);
}

TEST_F(NetworkDeviceTest, ReadsNoMoreThanABoundAtOnce) {
  for (std::uint64_t i = 1; i <= NetworkDevice::kMostDatagrams + 1; ++i) program_.Send(i);
  EXPECT_EQ(SequenceAt(0ms), static_cast<std::uint64_t>(NetworkDevice::kMostDatagrams));
  EXPECT_EQ(SequenceAt(1ms), static_cast<std::uint64_t>(NetworkDevice::kMostDatagrams) + 1);
}

TEST_F(NetworkDeviceTest, AnswersWhoeverSent) {
  program_.Send(1);
  static_cast<void>(device_.Read(Time(0ms)));
  device_.Feel({.sequence = 4, .echo = 1, .wrench = {0, 0, -5, 0, 0, 0}});
  const auto felt = program_.Receive();
  ASSERT_TRUE(felt.has_value());
  EXPECT_EQ(felt->sequence, 4u);
  EXPECT_EQ(felt->wrench[2], -5);
}

TEST_F(NetworkDeviceTest, EchoesTheNumberThatTheSenderKnows) {
  program_.Send(1);
  static_cast<void>(device_.Read(Time(0ms)));
  static_cast<void>(device_.Read(Time(2s)));
  other_.Send(70);
  EXPECT_EQ(SequenceAt(2001ms), 2u);
  device_.Feel({.sequence = 1, .echo = 2});
  device_.Feel({.sequence = 2, .echo = 1});  // of a sample from before its session
  EXPECT_EQ(other_.Receive()->echo, 70u);
  EXPECT_EQ(other_.Receive()->echo, 0u);
}

TEST_F(NetworkDeviceTest, AnswersNobodyAfterTheSilence) {
  program_.Send(1);
  static_cast<void>(device_.Read(Time(0ms)));
  static_cast<void>(device_.Read(Time(2s)));
  device_.Feel({});
  EXPECT_FALSE(program_.Receive().has_value());
}

TEST(NetworkSettingsTest, HearsThisMachineAndTheNetworkThatIsNamed) {
  NetworkSettings settings;
  EXPECT_TRUE(settings.MaySend(fci::Resolve("127.0.0.1", 0).address));
  EXPECT_FALSE(settings.MaySend(fci::Resolve("192.0.2.7", 0).address));
  settings.allow = fci::ParseNetwork("192.0.2.0/24");
  EXPECT_TRUE(settings.MaySend(fci::Resolve("127.0.0.1", 0).address));
  EXPECT_TRUE(settings.MaySend(fci::Resolve("192.0.2.7", 0).address));
  EXPECT_FALSE(settings.MaySend(fci::Resolve("192.0.3.7", 0).address));
}

TEST(NetworkSettingsTest, RefusesToBeReachedByNobodyKnowsWhom) {
  NetworkSettings settings;
  settings.bind.address = 0;
  EXPECT_THAT([&] { settings.Validate(); },
              ThrowsMessage<InputError>(HasSubstr("allow: ADDRESS/BITS")));
}

TEST(NetworkSettingsTest, RefusesSilencesOutOfRange) {
  NetworkSettings settings;
  settings.silence = 10ms;
  EXPECT_THAT([&] { settings.Validate(); }, ThrowsMessage<InputError>(HasSubstr("silence")));
}

/// The device of parameters.
std::unique_ptr<teleop::Device> Make(const control::Parameters& parameters, bool is_lockstep) {
  static const MonotonicClock clock;
  control::ParameterReader reader(parameters, "operator.device");
  return MakeNetworkDevice(
      {.parameters = reader, .folder = {}, .clock = clock, .is_lockstep = is_lockstep});
}

TEST(MakeNetworkDeviceTest, DrawsAnotherTokenEveryTime) {
  const control::Parameters any_port{{.key = "port", .values = {"0"}}};
  const auto token = [&] {
    const std::string text = Make(any_port, false)->Describe();
    return text.substr(text.find("token"));
  };
  EXPECT_NE(token(), token());
}

TEST(MakeNetworkDeviceTest, RefusesLockstep) {
  EXPECT_THAT([] { Make({}, true); }, ThrowsMessage<InputError>(HasSubstr("--drive realtime")));
}

TEST(MakeNetworkDeviceTest, NamesTheParameterThatIsWrong) {
  const auto with = [](const std::string& key, const std::string& value) {
    return [=] { Make({{.key = key, .values = {value}}}, false); };
  };
  EXPECT_THAT(with("port", "80.5"), ThrowsMessage<InputError>(HasSubstr("operator.device.port")));
  EXPECT_THAT(with("token", "seventeen letters"),
              ThrowsMessage<InputError>(HasSubstr("operator.device.token")));
  EXPECT_THAT(with("silence", "0 s"), ThrowsMessage<InputError>(HasSubstr("silence")));
  EXPECT_THAT(with("allow", "192.0.2.7"), ThrowsMessage<InputError>(HasSubstr("is no network")));
}

}  // namespace
}  // namespace twin::devices::devices_network_test
