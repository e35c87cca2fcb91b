#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "twin/core/clock.h"
#include "twin/core/hand_command.h"
#include "twin/fci/capture.h"
#include "twin/fci/client_timeout.h"
#include "twin/fci/sockets.h"

namespace twin::fci {

class RequestChannel;

/// A session with a hand that speaks the Franka Control Interface: commands over TCP, states over
/// UDP. Each command is answered when the action is over; meanwhile nobody waits. Source: FCI
/// protocol 5, gripper.
///
/// Threads: any. Not for real-time code.
class HandClient {
 public:
  /// Connects: TCP, the states' socket, and an agreement on the version.
  /// @param capture, @throws  as ArmClient.
  HandClient(const std::string& host, std::uint16_t port, const ClientTimeout& timeout = {},
             Capture* capture = nullptr);
  ~HandClient();
  HandClient(const HandClient&) = delete;
  HandClient& operator=(const HandClient&) = delete;

  /// Sends a command. One that still runs is aborted by it, and is given a second to say so: what
  /// became of it is then known when this returns. The same for the answer to Stop, which comes at
  /// once. @returns its name, above 0. @throws RobotFault when the connection is lost.
  HandTicket Start(const HandCommand& command);

  /// How a command ended; nothing while it runs. Asked of one of the last eight; earlier ones count
  /// as aborted. @throws RobotFault when the connection is lost before it was answered.
  [[nodiscard]] std::optional<HandResult> Outcome(HandTicket ticket);

  /// The newest state: when a command has just been answered, one that came after the answer, if it
  /// does within 0.1 s (states are some 20 ms apart).
  /// @throws RobotFault when none has ever come, or the connection is lost.
  [[nodiscard]] HandState State();

 private:
  class Mailbox;

  /// A command and how it ended.
  struct Sent {
    HandTicket ticket = 0;
    std::optional<HandResult> result;
  };

  void Negotiate(std::uint16_t udp_port);
  /// Looks whether the answer has come.
  void Update(Sent& sent, Duration timeout);

  const ClientTimeout timeout_;
  const std::string name_;  ///< for texts
  std::unique_ptr<Mailbox> states_;
  std::unique_ptr<RequestChannel> channel_;
  std::mutex mutex_;
  std::deque<Sent> sent_;  ///< guarded by mutex_; the last eight
};

}  // namespace twin::fci
