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
#include "twin/core/robot_command.h"
#include "twin/core/robot_state.h"
#include "twin/core/setting.h"
#include "twin/fci/capture.h"
#include "twin/fci/client_timeout.h"
#include "twin/fci/datagrams.h"
#include "twin/fci/requests.h"
#include "twin/fci/sockets.h"
#include "twin/rt/arrival.h"

namespace twin::fci {

class RequestChannel;

/// What came of a look for a state.
enum class Reception : std::uint8_t {
  kState,    ///< one was received
  kPending,  ///< none yet
  /// TCP has ended, no state has come for as long as the timeout for one, or one came in which a
  /// number is NaN or infinity.
  kLost,
};

/// Datagrams at the states' socket that were none to take.
struct ReceptionCounts {
  std::uint64_t old = 0;    ///< not newer than the last accepted: late, or doubled
  std::uint64_t ahead = 0;  ///< of an id that the robot cannot have reached since the last accepted
  /// Of another address than the robot's, or of another port than the first state's, as far as the
  /// kernel let them in (UdpSocket::ListenOnlyTo).
  std::uint64_t foreign = 0;
  std::uint64_t bad = 0;  ///< too short, or a mode or flag that does not exist
  bool operator==(const ReceptionCounts&) const = default;
};

/// A session with an arm that speaks the Franka Control Interface: requests over TCP, states and
/// commands over UDP. Source: FCI protocol 5, session and motion semantics.
///
///     any thread ---request---> TCP ---> robot      tick's thread <---states--- UDP <--- robot
///     any thread <--answer----- reader thread       tick's thread ---commands--> UDP ---> robot
///
/// Of the states, the newest counts: what is queued is drained (64 at a time, no more). The first
/// is accepted from the robot's address, the others from where the first came from; that is where
/// commands go. An id must be greater than the last accepted one's, by no more than
///   1000 + 2 a ms of the time since the socket was last found empty before that one:
/// a robot counts one a ms, so that what is further ahead is none of its states and must not make
/// all that follow old. Whoever sends in the robot's name from its own port is not recognised: the
/// interface has no secrets.
///
/// A number that is none (NaN, infinity) in a state ends the connection: no robot measures it, and
/// what compares with it takes all for well.
///
/// Unlike libfranka it waits for no answer without end: a connection that is closed, or an answer
/// that does not come, is a RobotFault.
///
/// Threads: requests from any; Receive() and Send() from one, the tick's. Real-time: these two and
/// the arrival are noexcept, lock nothing and allocate nothing.
class ArmClient {
 public:
  /// Connects: TCP, the states' socket, and an agreement on the version.
  /// @param clock  of instants and timeouts; must outlive the client. It may be restarted while
  ///               nobody receives.
  /// @param capture  keeps what is sent and received; must outlive the client. Null: nothing.
  /// @throws InputError when the host has no address; RobotFault when nothing answers there, or
  /// speaks another version, with both versions and the cure.
  ArmClient(const MonotonicClock& clock, const std::string& host, std::uint16_t port,
            const ClientTimeout& timeout = {}, Capture* capture = nullptr);
  ~ArmClient();
  ArmClient(const ArmClient&) = delete;
  ArmClient& operator=(const ArmClient&) = delete;

  [[nodiscard]] const Endpoint& robot() const noexcept { return robot_; }
  /// The robot's version of the interface, as it told.
  [[nodiscard]] std::uint16_t version() const noexcept { return version_; }

  /// @returns the first answer: kMotionStarted, or why not. @throws RobotFault when the connection
  /// is lost or no answer comes; so do the other requests.
  [[nodiscard]] MoveStatus Move(const fci::Move& move);
  /// The second answer to the last Move that started.
  /// @returns nothing when there was none, or its end is not known within `timeout`.
  [[nodiscard]] std::optional<MoveStatus> AwaitMotionEnd(Duration timeout) noexcept;
  /// Answered when the arm rests; at once when no motion runs.
  [[nodiscard]] StopStatus StopMove();
  [[nodiscard]] SetterStatus Configure(const Setting& setting);
  [[nodiscard]] SetterStatus CartesianLimitOf(std::int32_t id, CartesianLimit& limit);
  [[nodiscard]] RecoveryStatus Recover();
  /// Asks the robot whether it is a twin (fci/twin_sign.h). What answers in any other way, or not
  /// at all, may be a real arm. Changes nothing. @throws RobotFault when the connection is lost.
  [[nodiscard]] bool SaysItIsATwin();

  /// Never waits. @param state  written only for kState. @param at  when this side had it.
  [[nodiscard]] Reception Receive(RobotState& state, Time& at) noexcept TWIN_REALTIME;
  /// What the kernel does not take is lost, as on the wire; so is a command before the first state.
  void Send(const RobotCommand& command) noexcept TWIN_REALTIME;
  /// Where to wait for a state: returns as long as one is queued.
  [[nodiscard]] rt::Arrival& arrival() noexcept { return *udp_; }

  /// Whether TCP has ended. Real-time: noexcept.
  [[nodiscard]] bool lost() const noexcept;
  /// Why the connection is gone, for people; empty while it is not.
  [[nodiscard]] std::string WhyLost() const;
  /// Any thread: each figure by itself.
  [[nodiscard]] ReceptionCounts counts() const noexcept;

 private:
  struct Asked;

  void Negotiate();
  [[nodiscard]] Asked Ask(const ArmRequest& request, Duration timeout);
  [[nodiscard]] std::uint8_t AskForStatus(const ArmRequest& request, std::uint8_t last);
  [[nodiscard]] bool Accept(const Datagram& datagram) noexcept;
  /// The states have, for good.
  [[nodiscard]] bool has_ended() const noexcept {
    return silent_.load(std::memory_order_relaxed) ||
           no_number_.load(std::memory_order_relaxed) != nullptr;
  }
  [[nodiscard]] bool IsFromRobot(const Endpoint& from) const noexcept;
  [[nodiscard]] std::uint64_t MostAhead() const noexcept;
  [[nodiscard]] Reception FoundNone() noexcept;
  void Keep(Time at, const Endpoint& from, const Endpoint& to,
            std::span<const std::byte> bytes) noexcept TWIN_REALTIME;

  const MonotonicClock& clock_;
  const ClientTimeout timeout_;
  Capture* const capture_;
  const Endpoint robot_;
  std::uint16_t version_ = 0;
  std::unique_ptr<UdpSocket> udp_;
  std::unique_ptr<RequestChannel> channel_;

  std::mutex motion_;                        ///< guards the two
  std::optional<std::uint32_t> move_id_;     ///< whose second answer is awaited
  std::optional<MoveStatus> last_move_end_;  ///< of the last Move that started

  // The tick's.
  std::array<std::byte, kStateBytes> state_bytes_{};
  CommandBytes command_bytes_{};
  RobotState received_;
  std::uint64_t last_id_ = 0;
  bool has_state_ = false;
  Endpoint to_{};  ///< where the first state came from: of commands
  /// Of ids against time: clock_ may be restarted, this one is not.
  const MonotonicClock own_clock_;
  Time found_empty_{};  ///< when the socket was last; before the last accepted state: sent_after_
  Time sent_after_{};
  std::optional<Time> pending_since_;  ///< of the first look since the last state

  ReceptionCounts before_;   ///< up to the last accepted state
  ReceptionCounts instead_;  ///< of a state, when silent_

  // Counts only: relaxed. silent_ (release after instead_) and no_number_ are set once, by the
  // tick.
  std::atomic<std::uint64_t> old_ = 0;
  std::atomic<std::uint64_t> ahead_ = 0;
  std::atomic<std::uint64_t> foreign_ = 0;
  std::atomic<std::uint64_t> bad_ = 0;
  std::atomic<bool> silent_ = false;
  std::atomic<const char*> no_number_ = nullptr;  ///< name of the field
};

}  // namespace twin::fci
