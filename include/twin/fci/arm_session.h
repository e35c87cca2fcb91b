#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "twin/core/modes.h"
#include "twin/core/request_status.h"
#include "twin/core/setting.h"
#include "twin/fci/requests.h"

namespace twin::fci {

/// Robot data for a session, sent after each cycle that changed it.
struct ArmProgress {
  RobotMode mode = RobotMode::kOther;
  bool in_motion = false;  ///< the modes of the state are not idle
  /// Status of the last motion's Move: kMotionStarted while it runs and before the first motion.
  MoveStatus last_end = MoveStatus::kMotionStarted;
  bool operator==(const ArmProgress&) const = default;
};

/// What a session asks of the robot. A session answers with the returned status.
class ArmService {
 public:
  virtual ~ArmService() = default;
  [[nodiscard]] virtual MoveStatus Move(const fci::Move& move) = 0;
  virtual void StopMove() = 0;
  [[nodiscard]] virtual SetterStatus Configure(const Setting& setting) = 0;
  /// kSuccess: recovery has begun, or was not needed. Refused in Reflex while the arm still moves.
  [[nodiscard]] virtual RecoveryStatus Recover() = 0;
  /// @param limit  receives the virtual wall `id`.
  [[nodiscard]] virtual SetterStatus CartesianLimitOf(std::int32_t id, CartesianLimit& limit) = 0;
  /// The robot's URDF. Asked in protocol 10 alone.
  [[nodiscard]] virtual std::string_view RobotModel() = 0;
  /// Bytes of the model library for this machine; empty if unavailable.
  [[nodiscard]] virtual std::span<const std::byte> ModelLibrary(
      const LoadModelLibrary& machine) = 0;
  [[nodiscard]] virtual ArmProgress Progress() = 0;
};

/// Receives a session's answers, one whole frame per call, in order.
using Answers = std::function<void(std::span<const std::byte>)>;

/// One client's session with the arm, without sockets or time: requests in, answers out.
///
///     Connect -> (states flow) -> Move -> MotionStarted ... motion ends -> Move's second answer
///                                 StopMove -> answered when the arm rests, just before Move's
///
/// Every request gets one answer, an accepted Move two. Three answers wait for the robot, until
/// OnProgress() shows the event: the second one to Move, that to StopMove of a running motion, and
/// that to recovery. Source: FCI protocol 5, session and motion semantics. Decisions:
/// - StopMove without a motion succeeds at once: clients send it after every failure, and some exit
///   when it fails.
/// - StopMove succeeds, too, if the motion ends otherwise while it stops.
/// - A recovery requested before the arm rests after a reflex begins once it rests, although INT
///   refuses it: programs request it as soon as they see the reflex, and the real robot allows it.
///
/// Threads: one.
class ArmSession {
 public:
  /// @param protocol  that the robot speaks.
  ArmSession(ArmService& service, Answers answers, Protocol protocol = Protocol::k5);

  /// @returns nullopt, or the reason to close the connection after the answers are sent: the first
  /// request is not Connect; a second Connect; a Connect with another version (answered with ours)
  /// or without a UDP port; a malformed frame.
  [[nodiscard]] std::optional<std::string> OnFrame(const Frame& frame);

  /// The robot's progress has changed.
  void OnProgress(const ArmProgress& progress);

  /// The client has disconnected: stops a running motion. @note Sends no more answers.
  void OnClosed();

  /// The client's UDP port, to which states go; nullopt before Connect.
  [[nodiscard]] std::optional<std::uint16_t> udp_port() const noexcept { return udp_port_; }
  /// True while requests lack an answer. If the server ends such a connection, it must reset it
  /// instead of closing it; otherwise clients wait forever.
  [[nodiscard]] bool has_pending() const noexcept;

 private:
  using Outcome = std::optional<std::string>;  ///< as of OnFrame()

  Outcome Take(const Connect& connect);
  Outcome Take(const Move& move);
  Outcome Take(const StopMove& stop);
  Outcome Take(const GetCartesianLimit& request);
  Outcome Take(const Setting& setting);
  Outcome Take(const AutomaticErrorRecovery& request);
  Outcome Take(const LoadModelLibrary& machine);
  Outcome Take(const GetRobotModel& request);
  /// Starts the pending recovery, answers it, or keeps it for another try.
  void TryRecovery();
  void AnswerRecovery(RecoveryStatus status);
  template <typename Status>
  void Answer(ArmCommand command, std::uint32_t command_id, Status status);
  /// Answers the current request.
  template <typename Status>
  Outcome Answer(Status status);

  /// Upper bound of pending StopMoves; a client has at most one per thread.
  static constexpr std::size_t kMostStops = 64;

  ArmService& service_;
  const Answers answers_;
  const Protocol protocol_;
  FrameHead head_;                           ///< of the current request
  ArmCommand asked_ = ArmCommand::kConnect;  ///< the current request
  std::optional<std::uint16_t> udp_port_;
  std::optional<std::uint32_t> move_;  ///< command_id of the running motion's Move
  std::vector<std::uint32_t> stops_;   ///< StopMoves waiting for the motion's end
  struct Recovery {
    std::uint32_t command_id = 0;
    bool begun = false;  ///< false: the arm has not come to rest yet
  };
  std::optional<Recovery> recovery_;
};

}  // namespace twin::fci
