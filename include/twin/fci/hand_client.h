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
#include "twin/fci/protocol.h"
#include "twin/fci/sockets.h"

namespace twin::fci {

class RequestChannel;

/// A session with a hand or vacuum gripper that speaks the Franka Control Interface: commands over
/// TCP, states over UDP. A command is answered when its action is over; no call blocks until then.
/// Source: FCI protocol 5, gripper and vacuum gripper.
///
/// Threads: any. Not for real-time code.
class HandClient {
 public:
  /// Connects TCP, binds the state socket and checks the protocol version.
  /// @param capture, @throws  as ArmClient. @param device  that listens there.
  HandClient(const std::string& host, std::uint16_t port, const ClientTimeout& timeout = {},
             Capture* capture = nullptr, HandDevice device = HandDevice::kFrankaHand);
  ~HandClient();
  HandClient(const HandClient&) = delete;
  HandClient& operator=(const HandClient&) = delete;

  /// Sends a command. A command that still runs is aborted and has 1 s to answer, so its outcome is
  /// known on return; it goes on when the device refuses this one (kFail). Stop, which is answered
  /// at once, is treated the same. @returns the ticket, above 0. @pre the device has the command.
  /// @throws RobotFault if the connection is lost.
  HandTicket Start(const HandCommand& command);

  /// @returns how the command ended; nullopt while it runs. Keeps the last eight commands and
  /// reports older ones as aborted. @throws RobotFault if the connection is lost before the answer.
  [[nodiscard]] std::optional<HandResult> Outcome(HandTicket ticket);

  /// The newest state. Directly after an answer, waits up to 0.1 s for a state newer than the
  /// answer (states arrive every 20 ms or so).
  /// @throws RobotFault if no state has ever arrived, or the connection is lost.
  [[nodiscard]] HandState State();

 private:
  class Mailbox;

  /// A command and how it ended.
  struct Sent {
    HandTicket ticket = 0;
    std::optional<HandResult> result;
  };

  void Negotiate(std::uint16_t udp_port);
  /// Checks for the answer.
  void Update(Sent& sent, Duration timeout);

  const ClientTimeout timeout_;
  const HandDevice device_;
  const std::string name_;  ///< for messages
  std::unique_ptr<Mailbox> states_;
  std::unique_ptr<RequestChannel> channel_;
  std::mutex mutex_;
  std::deque<Sent> sent_;  ///< guarded by mutex_; the last eight
};

}  // namespace twin::fci
