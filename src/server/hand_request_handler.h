#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "twin/core/clock.h"
#include "twin/fci/capture.h"
#include "twin/fci/datagrams.h"
#include "twin/fci/hand_session.h"
#include "twin/fci/sockets.h"
#include "twin/robot/threaded_robot.h"
#include "twin/server/request_handler.h"

namespace twin::server {

/// Serves the client of the hand or vacuum gripper: its session, the device, and its states every
/// 10 ms.
///
/// Threads: one.
class HandRequestHandler final : public RequestHandler, private fci::HandService {
 public:
  /// All arguments must outlive the handler. @param address  of this machine, source of the states.
  /// @param capture  records the wire; may be null.
  HandRequestHandler(robot::ThreadedRobot& robot, const MonotonicClock& clock,
                     std::uint32_t address, const TellPeople& tell, fci::Capture* capture);

  [[nodiscard]] bool IsReady() override { return true; }
  void OnConnect(Connection& client) override;
  [[nodiscard]] std::optional<std::string> OnFrame(const fci::Frame& frame) override;
  [[nodiscard]] std::optional<std::string> Poll(Time now) override;
  [[nodiscard]] bool has_pending() const override { return session_->has_pending(); }
  void OnDisconnect() override { session_.reset(); }
  [[nodiscard]] Duration poll_timeout() const override;

 private:
  [[nodiscard]] HandStart Start(const HandCommand& command) override;
  [[nodiscard]] std::optional<HandResult> Outcome(HandTicket ticket) override;
  void SendState();
  /// @returns the datagram.
  [[nodiscard]] std::span<const std::byte> Encoded(const HandState& state);

  robot::ThreadedRobot& robot_;
  const MonotonicClock& clock_;
  const TellPeople& tell_;
  fci::Capture* capture_;
  fci::UdpSocket socket_;
  const HandDevice device_;
  fci::HandStateBytes outgoing_{};
  fci::VacuumStateBytes outgoing_vacuum_{};

  std::optional<fci::HandSession> session_;
  fci::Endpoint client_;
  bool connected_ = false;
  Time next_state_{};
  std::optional<std::uint32_t> last_id_;  ///< of the states that the client was sent
};

}  // namespace twin::server
