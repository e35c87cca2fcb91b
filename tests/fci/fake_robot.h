#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "twin/core/clock.h"
#include "twin/fci/datagrams.h"
#include "twin/fci/frame_reader.h"
#include "twin/fci/requests.h"
#include "twin/fci/sockets.h"
#include "twin/rt/host_time.h"

namespace twin::test {

/// A robot of a script: it takes one client, agrees to its Connect (unless told otherwise), and for
/// every other request does what the test says. Its states are sent by the test.
///
/// Threads: a thread of its own serves TCP, and calls the script there; Send...() from the test.
class FakeRobot {
 public:
  /// What to do about a request: bytes to send, if any.
  using Script = std::function<std::vector<std::byte>(FakeRobot& robot, const fci::Frame& request)>;

  FakeRobot(fci::HeadKind kind, Script script)
      : kind_(kind),
        script_(std::move(script)),
        thread_([this](const std::stop_token& stop) { Serve(stop); }) {}

  [[nodiscard]] std::uint16_t port() const { return listener_.local().port; }

  /// Of the hand's kind, and speaks this version.
  void Speaks(std::uint16_t version) { hand_version_ = version; }
  /// Instead of agreeing: the version it tells.
  void OnlySpeaks(std::uint16_t version) { version_ = version; }

  /// Answers with what the script told to send, and ends the connection then.
  void CloseAfterwards() { ending_ = Ending::kClose; }
  void ResetAfterwards() { ending_ = Ending::kReset; }

  /// Sends a datagram to the client. @param from  the source; absent: the robot's usual socket.
  void SendDatagram(std::span<const std::byte> bytes, fci::UdpSocket* from = nullptr) {
    while (udp_port_ == 0) rt::Pause(std::chrono::milliseconds(1));
    (from == nullptr ? udp_ : *from).Send(bytes, {kHere, udp_port_});
  }
  void SendState(const RobotState& state, fci::UdpSocket* from = nullptr) {
    fci::StateBytes bytes{};
    fci::Encode(state, bytes);
    SendDatagram(bytes, from);
  }
  void SendStateId(std::uint64_t id, fci::UdpSocket* from = nullptr) {
    RobotState state;
    state.message_id = id;
    SendState(state, from);
  }

  /// The next command that came to `at` (absent: the usual socket), within 5 s.
  std::optional<RobotCommand> AwaitCommand(fci::UdpSocket* at = nullptr) {
    fci::UdpSocket& socket = at == nullptr ? udp_ : *at;
    if (!socket.AwaitUntil(clock_.Now() + std::chrono::seconds(5))) return {};
    fci::CommandBytes bytes{};
    const auto datagram = socket.Receive(bytes);
    RobotCommand command;
    if (!datagram || fci::Decode(datagram->bytes, command) != fci::DatagramFault::kNone) return {};
    return command;
  }

  [[nodiscard]] const MonotonicClock& clock() const { return clock_; }
  static constexpr std::uint32_t kHere = 0x7f000001;
  static constexpr std::uint32_t kElsewhere = 0x7f000002;  ///< this machine all the same

 private:
  enum class Ending : std::uint8_t { kNone, kClose, kReset };

  void Serve(const std::stop_token& stop) {
    std::optional<fci::TcpStream> stream;
    fci::FrameReader reader(kind_, fci::kLargestArmRequest);
    while (!stop.stop_requested()) {
      rt::Pause(std::chrono::milliseconds(1));
      if (!stream) {
        stream = listener_.Accept();
        continue;
      }
      std::size_t received = 0;
      if (stream->Receive(reader.Room(), received) != fci::StreamResult::kDone) continue;
      reader.Received(received);
      while (const auto frame = reader.Next()) Answer(*frame, *stream);
    }
  }

  void Answer(const fci::Frame& frame, fci::TcpStream& stream) {
    const std::vector<std::byte> bytes =
        frame.head.command == 0 ? Agree(frame) : script_(*this, frame);
    std::size_t sent = 0;
    if (!bytes.empty()) static_cast<void>(stream.Send(bytes, sent));
    if (ending_ == Ending::kClose) stream.Close();
    if (ending_ == Ending::kReset) stream.ResetConnection();
  }

  std::vector<std::byte> Agree(const fci::Frame& frame) {
    const bool arm = kind_ == fci::HeadKind::kArm;
    const std::uint16_t own = arm ? fci::VersionOf(fci::Protocol::k5) : hand_version_.load();
    const std::uint16_t version = version_ == 0 ? own : version_.load();
    const fci::ConnectStatus status = version == own
                                          ? fci::ConnectStatus::kSuccess
                                          : fci::ConnectStatus::kIncompatibleLibraryVersion;
    if (arm) {
      const auto request = fci::ParseArmRequest(frame);
      udp_port_ = std::get<fci::Connect>(std::get<fci::ArmRequest>(request)).udp_port;
      return fci::EncodeArmConnectAnswer(frame.head.command_id, status, version);
    }
    const auto request = fci::ParseHandRequest(frame);
    udp_port_ = std::get<fci::Connect>(std::get<fci::HandRequest>(request)).udp_port;
    return fci::EncodeHandConnectAnswer(frame.head.command_id, status, version);
  }

  const fci::HeadKind kind_;
  const Script script_;
  const MonotonicClock clock_;
  fci::TcpListener listener_{fci::Endpoint{kHere, 0}};
  fci::UdpSocket udp_{clock_, fci::Endpoint{kHere, 0}};
  std::atomic<std::uint16_t> version_ = 0;  ///< 0: the right one
  std::atomic<std::uint16_t> hand_version_ = fci::kHandVersion;
  std::atomic<std::uint16_t> udp_port_ = 0;
  std::atomic<Ending> ending_ = Ending::kNone;
  std::jthread thread_;
};

}  // namespace twin::test
