#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>

#include "twin/core/clock.h"
#include "twin/core/realtime.h"
#include "twin/core/request_status.h"
#include "twin/core/robot_state.h"
#include "twin/core/setting.h"
#include "twin/fci/capture.h"
#include "twin/fci/datagrams.h"
#include "twin/fci/protocol.h"
#include "twin/fci/requests.h"
#include "twin/fci/sockets.h"
#include "twin/fci/twin_sign.h"
#include "twin/rt/signal.h"

namespace twin::fci {

class RequestChannel;

/// Outcome of a non-blocking receive.
enum class ReceiveResult : std::uint8_t {
  kState,    ///< a state was received
  kPending,  ///< no state yet
  /// TCP has ended, the timeout for a state has passed, or a state contains NaN or infinity.
  kLost,
};

/// Datagrams rejected at the state socket.
struct RejectedDatagrams {
  std::uint64_t old = 0;    ///< not newer than the last accepted state: late or duplicated
  std::uint64_t ahead = 0;  ///< an id that the robot cannot have reached yet
  /// Not from the robot's address, or not from the port of the first state; counts only those that
  /// the kernel let in (UdpSocket::ListenOnlyTo).
  std::uint64_t foreign = 0;
  std::uint64_t bad = 0;  ///< too short, or with an unknown mode or flag
  bool operator==(const RejectedDatagrams&) const = default;
};

/// A session with an arm that speaks the Franka Control Interface: requests over TCP, states and
/// commands over UDP. Source: FCI protocol 5, session and motion semantics.
///
///     any thread ---request---> TCP ---> robot      tick's thread <---states--- UDP <--- robot
///     any thread <--answer----- reader thread       tick's thread ---commands--> UDP ---> robot
///
/// Receive() returns the newest state: it drains the queue, at most 64 datagrams a call. The first
/// state is accepted from the robot's address, later ones only from the first one's source, which
/// is also where commands go. An id must exceed the last accepted one, by at most 1000 + 2 per ms
/// since the socket was last empty before that state. A robot counts 1 per ms, so a higher id is
/// not from its states and would make all following ones old. A sender that forges the robot's
/// address and port is not detected, because the interface has no authentication.
///
/// NaN or infinity in a state ends the connection: no robot measures it, and no comparison with
/// a limit would reject it.
///
/// Unlike libfranka, no call waits forever: a closed connection or a missing answer is a
/// RobotFault.
///
/// Threads: requests from any; Receive() and Send() from one, the tick's. Real-time: these two and
/// arrival() are noexcept and neither lock nor allocate.
class ArmClient {
 public:
  /// Connects TCP, binds the state socket and checks the protocol version.
  /// @param protocol  that the robot must speak.
  /// @param clock  for instants and timeouts; must outlive the client. It may be restarted while no
  /// Receive() runs.
  /// @param capture  records what is sent and received; must outlive the client. May be null.
  /// @throws InputError if the host has no address; RobotFault if the host does not answer, or has
  /// another version (names both versions and the cure).
  ArmClient(const MonotonicClock& clock, const std::string& host, std::uint16_t port,
            const ClientTimeout& timeout = {}, Capture* capture = nullptr,
            Protocol protocol = Protocol::k5);
  ~ArmClient();
  ArmClient(const ArmClient&) = delete;
  ArmClient& operator=(const ArmClient&) = delete;

  [[nodiscard]] const Endpoint& robot() const noexcept { return robot_; }
  /// The robot's protocol version.
  [[nodiscard]] std::uint16_t version() const noexcept { return version_; }

  /// @returns the first answer: kMotionStarted, or the reason for the refusal. @throws RobotFault,
  /// as do all requests, if the connection is lost or no answer comes.
  [[nodiscard]] MoveStatus Move(const fci::Move& move);
  /// Waits for the second answer to the last Move that started.
  /// @returns nullopt without a motion, or if its end does not arrive within `timeout`.
  [[nodiscard]] std::optional<MoveStatus> AwaitMotionEnd(Duration timeout) noexcept;
  /// Returns once the arm is at rest; at once without a motion.
  [[nodiscard]] StopStatus StopMove();
  [[nodiscard]] SetterStatus Configure(const Setting& setting);
  /// Protocol 5.
  [[nodiscard]] SetterStatus CartesianLimitOf(std::int32_t id, CartesianLimit& limit);
  [[nodiscard]] RecoveryStatus Recover();
  /// Asks the robot whether it is a twin (fci/twin_sign.h). kNone for any other answer or none: it
  /// may be a real arm. Changes nothing. @throws RobotFault if the connection is lost.
  [[nodiscard]] TwinKind AskForTwin();

  /// The robot waits for the answer to each of its states, and sends one again that it believes
  /// unanswered: from now on, Receive() sends the answer again when the last state comes again.
  /// @param silence  instead of ClientTimeout::state. @pre before the first Receive().
  void AnswerAgain(Duration silence) noexcept {
    answers_again_ = true;
    silence_ = silence;
  }

  /// Never waits. @param state  written only for kState. @param at  arrival time at this side.
  [[nodiscard]] ReceiveResult Receive(RobotState& state, Time& at) noexcept TWIN_REALTIME;
  /// A command that the kernel does not take is lost, as on the wire; so is one before the first
  /// state.
  void Send(const RobotCommand& command) noexcept TWIN_REALTIME;
  /// Waits for states: returns while one is queued.
  [[nodiscard]] rt::Arrival& arrival() noexcept { return *udp_; }

  /// True once TCP has ended. Real-time: noexcept.
  [[nodiscard]] bool lost() const noexcept;
  /// Reason for the loss of the connection, for users; empty while it is up.
  [[nodiscard]] std::string WhyLost() const;
  /// Threads: any; each count is read separately.
  [[nodiscard]] RejectedDatagrams counts() const noexcept;

 private:
  struct Asked;

  void Negotiate();
  [[nodiscard]] Asked Ask(const ArmRequest& request, Duration timeout);
  [[nodiscard]] std::uint8_t AskForStatus(const ArmRequest& request, std::uint8_t last);
  [[nodiscard]] bool Accept(const Datagram& datagram) noexcept;
  /// True once the stream of states has ended; stays true.
  [[nodiscard]] bool has_ended() const noexcept {
    return silent_.load(std::memory_order_relaxed) ||
           no_number_.load(std::memory_order_relaxed) != nullptr;
  }
  [[nodiscard]] bool IsFromRobot(const Endpoint& from) const noexcept;
  [[nodiscard]] std::uint64_t MostAhead() const noexcept;
  [[nodiscard]] ReceiveResult FoundNone() noexcept;
  void SendAgain() noexcept TWIN_REALTIME;
  void SendBytes() noexcept TWIN_REALTIME;
  void Keep(Time at, const Endpoint& from, const Endpoint& to,
            std::span<const std::byte> bytes) noexcept TWIN_REALTIME;

  const MonotonicClock& clock_;
  const ClientTimeout timeout_;
  const Protocol protocol_;
  Duration silence_;            ///< longest time without a state
  bool answers_again_ = false;  ///< a state that comes again
  Capture* const capture_;
  const Endpoint robot_;
  std::uint16_t version_ = 0;
  std::unique_ptr<UdpSocket> udp_;
  std::unique_ptr<RequestChannel> channel_;

  std::mutex motion_;                        ///< guards move_id_ and last_move_end_
  std::optional<std::uint32_t> move_id_;     ///< the Move whose second answer is pending
  std::optional<MoveStatus> last_move_end_;  ///< of the last Move that started

  // The tick's.
  std::array<std::byte, kStateBytes> state_bytes_{};
  AnyCommandBytes command_bytes_{};
  std::uint64_t answered_id_ = 0;  ///< state that command_bytes_ answers; 0: none
  RobotState received_;
  std::uint64_t last_id_ = 0;
  bool has_state_ = false;
  Endpoint to_{};  ///< source of the first state, and destination of commands
  /// Relates ids to time: clock_ may be restarted, this clock is not.
  const MonotonicClock own_clock_;
  Time found_empty_{};  ///< when the socket was last empty; sent_after_: its value before the last
                        ///< accepted state
  Time sent_after_{};
  std::optional<Time> pending_since_;  ///< time of the first Receive() since the last state

  RejectedDatagrams before_;   ///< up to the last accepted state
  RejectedDatagrams instead_;  ///< rejected instead of a state, when silent_

  // Counters: relaxed. silent_ (release, after instead_) and no_number_ are set once, by the tick.
  std::atomic<std::uint64_t> old_ = 0;
  std::atomic<std::uint64_t> ahead_ = 0;
  std::atomic<std::uint64_t> foreign_ = 0;
  std::atomic<std::uint64_t> bad_ = 0;
  std::atomic<bool> silent_ = false;
  std::atomic<const char*> no_number_ = nullptr;  ///< name of the field
};

}  // namespace twin::fci
