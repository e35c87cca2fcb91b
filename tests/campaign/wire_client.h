#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "twin/core/clock.h"
#include "twin/core/robot_state.h"
#include "twin/fci/frame_reader.h"
#include "twin/fci/requests.h"
#include "twin/fci/sockets.h"

namespace twin::campaign {

/// Something that a robot at the other end of a wire must not do; what() says what it did.
class BrokenPromise : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A bare FCI client: sends what it is told to, and holds the server to one answer per request, a
/// second one per started motion.
///
/// Threads: one, which waits. Errors: BrokenPromise; RobotFault if nobody listens.
class WireClient {
 public:
  WireClient(const fci::Endpoint& arm, fci::Protocol protocol);

  /// The request that opens a session in order.
  [[nodiscard]] fci::Connect Hello() const {
    return {fci::VersionOf(protocol_), udp_.local().port};
  }

  /// Makes the frame of a request and notes that an answer is owed. @returns its command_id.
  std::uint32_t Frame(const fci::ArmRequest& request, std::vector<std::byte>& bytes);
  /// Sends bytes in pieces that end at `cuts`, offsets in rising order.
  void Send(std::span<const std::byte> bytes, std::span<const std::size_t> cuts = {});
  /// Frame, Send, and the answer's status.
  std::uint8_t Ask(const fci::ArmRequest& request);
  /// Waits for the next answer to this request. Those to others that come before are kept.
  std::uint8_t AwaitAnswer(std::uint32_t command_id);
  /// Command ids in the order in which answers came.
  [[nodiscard]] const std::vector<std::uint32_t>& answered() const { return answered_; }
  /// A motion's start was answered: another answer is owed.
  void OweEnd(std::uint32_t move) { owed_[move] = fci::ArmCommand::kMove; }
  /// Waits until the server ends the connection.
  void AwaitClosed();

  /// Waits for a state with an id above this one. @returns the newest; nullopt: none came for so
  /// long.
  [[nodiscard]] std::optional<RobotState> AwaitState(std::uint64_t above, Duration longest);
  /// Sends a datagram to where states come from.
  void SendDatagram(std::span<const std::byte> bytes);
  void Command(const RobotCommand& command);

  void Close() { tcp_.Close(); }
  void Reset() { tcp_.ResetConnection(); }

 private:
  /// @returns whether something came. @throws BrokenPromise for what nobody asked for.
  bool Take();
  bool Wait(int fd, Time deadline);

  const fci::Protocol protocol_;
  MonotonicClock clock_;
  fci::UdpSocket udp_;
  fci::TcpStream tcp_;
  fci::FrameReader reader_;
  std::optional<fci::Endpoint> robot_;  ///< where states come from
  std::uint32_t last_command_id_ = 0;
  std::map<std::uint32_t, fci::ArmCommand> owed_;
  std::multimap<std::uint32_t, std::uint8_t> kept_;  ///< statuses nobody has waited for yet
  std::vector<std::uint32_t> answered_;
  std::uint64_t last_id_ = 0;
  bool is_closed_ = false;
};

}  // namespace twin::campaign
