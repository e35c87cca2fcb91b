#include "plugins/devices/network_device.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

#include <fmt/format.h>

#include "plugins/devices/lockstep_refusal.h"
#include "twin/core/error.h"
#include "twin/core/secret.h"
#include "twin/teleop/operator_ranges.h"

namespace twin::devices {
namespace {

using teleop::OperatorSample;

/// Including the padding zeros.
std::string_view WholeOf(const Token& token) noexcept {
  return {token.data(), token.size()};
}

std::string_view TextOf(const Token& token) {
  const std::string_view whole = WholeOf(token);
  return whole.substr(0, whole.find('\0'));
}

}  // namespace

void NetworkSettings::Validate() const {
  RequireInRange("network device: silence (s)", ToSeconds(silence), 0.05, 60);
  if (fci::IsLoopback(bind.address) || allow) return;
  throw InputError(
      "network device: bound to an address that other machines reach, whoever is there could move "
      "the robot: name the network that may with `allow: ADDRESS/BITS`, or leave `bind` out");
}

bool NetworkSettings::MaySend(std::uint32_t address) const noexcept {
  return fci::IsLoopback(address) || (allow && allow->Contains(address));
}

NetworkDevice::NetworkDevice(const MonotonicClock& clock, const NetworkSettings& settings)
    : settings_((settings.Validate(), settings)), socket_(clock, settings.bind) {}

std::optional<OperatorSample> NetworkDevice::Read(Time now) noexcept {
  std::optional<OperatorSample> newest;
  // One byte longer than a sample, to detect longer datagrams.
  std::array<std::byte, kSampleBytes + 1> room;
  for (int i = 0; i < kMostDatagrams; ++i) {
    const std::optional<fci::Datagram> datagram = socket_.Receive(room);
    if (!datagram) break;
    if (const auto sample = Take(*datagram, now)) newest = sample;
  }
  if (peer_ && now - heard_ > settings_.silence) {
    peer_.reset();
    lost_.store(true, std::memory_order_relaxed);
  }
  return newest;
}

std::optional<OperatorSample> NetworkDevice::Take(const fci::Datagram& datagram,
                                                  Time now) noexcept {
  const bool is_foreign =
      !settings_.MaySend(datagram.from.address) || (peer_ && *peer_ != datagram.from);
  if (is_foreign) {
    ++tally_.foreign;
    return {};
  }
  const std::optional<SampleMessage> message = ParseSample(datagram.bytes);
  if (!message) {
    ++tally_.malformed;
    return {};
  }
  if (!IsSameSecret(WholeOf(message->token), WholeOf(settings_.token))) {
    ++tally_.wrong_token;
    return {};
  }
  if (!peer_) {
    BeginSession(datagram.from, message->sample);
  } else if (message->sample.sequence <= last_) {
    ++tally_.overtaken;
    return {};
  }
  ++tally_.taken;
  heard_ = now;
  last_ = message->sample.sequence;
  OperatorSample sample = message->sample;
  sample.sequence += offset_.sequence;
  for (const auto presses : teleop::kPresses) {
    const std::uint32_t before = given_.*presses - offset_.*presses;
    if (sample.*presses < before) offset_.*presses += before - sample.*presses;
    sample.*presses += offset_.*presses;
  }
  given_ = sample;
  lost_.store(false, std::memory_order_relaxed);
  return given_;
}

void NetworkDevice::BeginSession(const fci::Endpoint& peer, const OperatorSample& first) noexcept {
  peer_ = peer;
  first_ = first.sequence;
  // Our sequence continues with the session's first sample, and presses keep their count. All are
  // unsigned: a subtraction may wrap, and the addition reverses it.
  offset_.sequence = given_.sequence + 1 - first.sequence;
  for (const auto presses : teleop::kPresses) offset_.*presses = given_.*presses - first.*presses;
}

void NetworkDevice::Feel(const teleop::OperatorFeedback& feedback) noexcept {
  if (!peer_) return;
  teleop::OperatorFeedback told = feedback;
  // The program does not know samples from before its session.
  const std::uint64_t echo = feedback.echo - offset_.sequence;
  told.echo = echo >= first_ && echo <= last_ ? echo : 0;
  std::array<std::byte, kFeedbackBytes> bytes;
  WriteFeedback(told, bytes);
  static_cast<void>(socket_.Send(bytes, *peer_));  // the next feedback replaces a lost one
}

std::string NetworkDevice::Describe() const {
  return fmt::format("a program at {} (UDP), token {}", fci::ToString(socket_.local()),
                     TextOf(settings_.token));
}

std::unique_ptr<teleop::Device> MakeNetworkDevice(const teleop::DeviceRequest& request) {
  RefuseLockstep(request, "network");
  control::ParameterReader& parameters = request.parameters;
  NetworkSettings settings;
  const auto port = parameters.Number("port", settings.bind.port, 0, 65535);
  if (port != std::floor(port)) parameters.Refuse("port", "must be a whole number");
  settings.bind =
      fci::Resolve(parameters.Text("bind", "127.0.0.1"), static_cast<std::uint16_t>(port));
  if (const std::string allow = parameters.Text("allow", ""); !allow.empty()) {
    settings.allow = fci::ParseNetwork(allow);
  }
  settings.silence = parameters.Time("silence", settings.silence, std::chrono::milliseconds(50),
                                     std::chrono::minutes(1));
  const std::string text = parameters.Text("token", "");
  const std::optional<Token> token = TokenOf(text.empty() ? MakeSecret(Token().size()) : text);
  if (!token) parameters.Refuse("token", "must be 1 to 16 printable characters of ASCII");
  settings.token = *token;
  return std::make_unique<NetworkDevice>(request.clock, settings);
}

}  // namespace twin::devices
