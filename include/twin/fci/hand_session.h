#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "twin/core/hand_command.h"
#include "twin/fci/arm_session.h"
#include "twin/fci/requests.h"

namespace twin::fci {

/// The hand as seen by a session.
class HandService {
 public:
  virtual ~HandService() = default;
  /// As backend::Hand::Start, but a refusal has ticket 0.
  [[nodiscard]] virtual HandStart Start(const HandCommand& command) = 0;
  [[nodiscard]] virtual std::optional<HandResult> Outcome(HandTicket ticket) = 0;
};

/// One client's session with the hand or the vacuum gripper, without sockets or time. Each request
/// is answered once, when its action is over. Requests are read meanwhile, so that Stop can abort a
/// command. Source: FCI protocol 5, gripper and vacuum gripper.
///
/// Threads: one.
class HandSession {
 public:
  HandSession(HandService& service, Answers answers, HandDevice device = HandDevice::kFrankaHand);

  /// As ArmSession.
  [[nodiscard]] std::optional<std::string> OnFrame(const Frame& frame);
  /// Time has advanced: answers the commands that are over.
  void OnProgress();

  [[nodiscard]] std::optional<std::uint16_t> udp_port() const noexcept { return udp_port_; }
  [[nodiscard]] bool has_pending() const noexcept { return !pending_.empty(); }

 private:
  /// A running command.
  struct Pending {
    HandTicket ticket = 0;
    HandCommandId command{};  ///< as numbered by the device
    std::uint32_t command_id = 0;
  };

  [[nodiscard]] std::optional<std::string> Take(const Connect& connect, std::uint32_t command_id);
  void Take(const HandCommand& command, const FrameHead& head);

  HandService& service_;
  const Answers answers_;
  const HandDevice device_;
  std::optional<std::uint16_t> udp_port_;
  std::vector<Pending> pending_;  ///< in order of arrival
};

}  // namespace twin::fci
