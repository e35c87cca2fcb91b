#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "twin/core/modes.h"
#include "twin/core/request_status.h"
#include "twin/core/setting.h"
#include "twin/fci/requests.h"

namespace twin::fci {

/// What a session needs to know of the robot after each cycle in which it changed.
struct ArmProgress {
  RobotMode mode = RobotMode::kOther;
  bool in_motion = false;  ///< the modes of the state are not idle
  /// How the last motion ended; kMotionStarted while one runs or before the first.
  MoveStatus last_end = MoveStatus::kMotionStarted;
  bool operator==(const ArmProgress&) const = default;
};

/// The robot, as a session sees it. Answers are those of INT.
class ArmService {
 public:
  virtual ~ArmService() = default;
  [[nodiscard]] virtual MoveStatus Move(const fci::Move& move) = 0;
  virtual void StopMove() = 0;
  [[nodiscard]] virtual SetterStatus Configure(const Setting& setting) = 0;
  /// kSuccess: it has begun, or there was nothing to recover from. Not possible in Reflex: the arm
  /// has not come to rest yet.
  [[nodiscard]] virtual RecoveryStatus Recover() = 0;
  [[nodiscard]] virtual SetterStatus CartesianLimitOf(std::int32_t id, CartesianLimit& limit) = 0;
  /// Bytes of the library for such a machine; empty: there is none.
  [[nodiscard]] virtual std::span<const std::byte> ModelLibrary(
      const LoadModelLibrary& machine) = 0;
  [[nodiscard]] virtual ArmProgress Progress() = 0;
};

/// Where a session's answers go: the whole frame at a time, in this order.
using Answers = std::function<void(std::span<const std::byte>)>;

/// One client's session with the arm, without sockets and without time: requests in, answers out.
///
///     Connect -> (states flow) -> Move -> MotionStarted ... motion ends -> Move's second answer
///                                 StopMove -> answered when the arm rests, just before Move's
///
/// Every request is answered once, Move twice unless rejected. What is answered later: Move's end,
/// StopMove of a running motion, recovery; each when OnProgress() shows it. StopMove without a
/// motion is answered with success at once: clients send it after every failure and some end
/// themselves when it fails. For the same reason a StopMove is a success, too, when the motion ends
/// otherwise while it is being stopped (a decision). Recovery that is asked for while the arm still
/// comes to rest after a reflex begins when it rests: programs recover in the same breath in which
/// they learn of the reflex, and the real robot lets them (a decision; INT itself refuses). Source:
/// FCI protocol 5, session and motion semantics.
///
/// Threads: one.
class ArmSession {
 public:
  ArmSession(ArmService& service, Answers answers);

  /// @returns what must happen to the connection: nothing; the reason why it has to be closed, once
  /// what was answered is on its way. A first request that is no Connect, a second Connect, a
  /// Connect of another version (answered with ours) or without a port for states, and a frame that
  /// is none all close it.
  [[nodiscard]] std::optional<std::string> OnFrame(const Frame& frame);

  /// The robot has changed.
  void OnProgress(const ArmProgress& progress);

  /// The client has gone: a running motion is stopped. @note Nothing is answered any more.
  void OnClosed();

  /// Where states go, once connected: the client's UDP port.
  [[nodiscard]] std::optional<std::uint16_t> udp_port() const noexcept { return udp_port_; }
  /// Requests that were not answered to their end yet: such a connection must be reset, not closed,
  /// when the server ends it, or clients wait for ever.
  [[nodiscard]] bool has_pending() const noexcept;

 private:
  using Outcome = std::optional<std::string>;

  Outcome Take(const Connect& connect);
  Outcome Take(const Move& move);
  Outcome Take(const StopMove& stop);
  Outcome Take(const GetCartesianLimit& request);
  Outcome Take(const Setting& setting);
  Outcome Take(const AutomaticErrorRecovery& request);
  Outcome Take(const LoadModelLibrary& machine);
  /// Begins the recovery that was asked for, answers it, or leaves it to be tried again.
  void TryRecovery();
  void AnswerRecovery(RecoveryStatus status);
  template <typename Status>
  void Answer(ArmCommand command, std::uint32_t command_id, Status status);
  /// Answers the request at hand.
  template <typename Status>
  Outcome Answer(Status status);

  /// StopMoves that may wait at once; no client has more than one per thread.
  static constexpr std::size_t kMostStops = 64;

  ArmService& service_;
  const Answers answers_;
  FrameHead head_;  ///< of the request at hand
  std::optional<std::uint16_t> udp_port_;
  std::optional<std::uint32_t> move_;  ///< command_id of the running motion's Move
  std::vector<std::uint32_t> stops_;   ///< of StopMoves that wait for its end, as they came
  struct Recovery {
    std::uint32_t command_id = 0;
    bool begun = false;  ///< no: the arm still comes to rest
  };
  std::optional<Recovery> recovery_;
};

}  // namespace twin::fci
