#include "plugins/backends.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <variant>

#include <fmt/format.h>

#include "plugins/fci/fci_hand.h"
#include "twin/backend/refusal.h"
#include "twin/core/error.h"
#include "twin/fci/arm_client.h"

namespace twin::plugins {
namespace {

/// Longest delay of a motion's end on TCP after the states.
constexpr Duration kEndTimeout = std::chrono::seconds(1);
/// State timeout for a robot whose states are its clock: its computing time is unbounded, but no
/// cycle takes seconds.
constexpr Duration kLongTimeout = std::chrono::seconds(5);

fci::ClientTimeout TimeoutFor(const backend::RobotAddress& address) {
  fci::ClientTimeout timeout;
  timeout.state = address.silence;
  return timeout;
}

/// @param kind  what the robot says.
backend::RobotTime TimeOf(const backend::RobotAddress& address, fci::TwinKind kind) {
  if (address.time != backend::RobotTime::kAsItSays) return address.time;
  return kind == fci::TwinKind::kInLockstep ? backend::RobotTime::kStates
                                            : backend::RobotTime::kWall;
}

/// The last requested motion, as shown by states.
///
///     kNone --Start--> kAsked --granted--> kGranted --modes--> kMoving --left--> kEnded
///
/// Threads: Ask(), Grant() and Refuse() from the starting thread, Observe() from the tick, the rest
/// from any.
class ObservedMotion {
 public:
  void Ask(const MotionModes& modes) noexcept {
    before_ = phase_.load(std::memory_order_acquire);
    modes_.store({modes.controller, modes.generator},
                 std::memory_order_relaxed);  // the phase's release publishes them
    phase_.store(Phase::kAsked, std::memory_order_release);
  }
  void Grant() noexcept {
    Phase asked = Phase::kAsked;  // the tick may already have observed the motion
    phase_.compare_exchange_strong(asked, Phase::kGranted, std::memory_order_acq_rel);
  }
  void Refuse() noexcept { phase_.store(before_, std::memory_order_release); }

  /// A state was read.
  void Observe(const RobotState& state) noexcept TWIN_REALTIME {
    const Phase phase = phase_.load(std::memory_order_acquire);
    if (phase == Phase::kNone || phase == Phase::kEnded) return;
    const Modes modes = modes_.load(std::memory_order_relaxed);
    const bool in_motion = state.robot_mode == RobotMode::kMove &&
                           state.motion_generator_mode == modes.generator &&
                           state.controller_mode == modes.controller;
    if (in_motion) {
      phase_.store(Phase::kMoving, std::memory_order_release);
      return;
    }
    // A motion that ended in its first cycle never shows its modes.
    const bool aborted_unseen =
        phase == Phase::kGranted &&
        (state.robot_mode == RobotMode::kReflex || state.robot_mode == RobotMode::kUserStopped);
    if (phase != Phase::kMoving && !aborted_unseen) return;
    errors_.store(state.reflex_reason.to_ullong(), std::memory_order_relaxed);
    phase_.store(Phase::kEnded, std::memory_order_release);
  }

  [[nodiscard]] bool begun() const noexcept {
    return phase_.load(std::memory_order_acquire) != Phase::kNone;
  }
  [[nodiscard]] bool ended() const noexcept {
    return phase_.load(std::memory_order_acquire) == Phase::kEnded;
  }
  /// reflex_reason of the state that left the motion. @pre ended()
  [[nodiscard]] RobotErrors errors() const noexcept {
    return errors_.load(std::memory_order_relaxed);
  }

 private:
  enum class Phase : std::uint8_t { kNone, kAsked, kGranted, kMoving, kEnded };
  struct Modes {
    ControllerMode controller;
    MotionGeneratorMode generator;
  };
  static_assert(std::atomic<Modes>::is_always_lock_free);

  std::atomic<Phase> phase_ = Phase::kNone;  ///< release after its data, acquire to read
  std::atomic<Modes> modes_{};
  std::atomic<std::uint64_t> errors_ = 0;
  Phase before_ = Phase::kNone;  ///< owned by the starting thread
};

class FciBackend final : public backend::Backend {
 public:
  FciBackend(const backend::Request& request, const backend::RobotAddress& address,
             const MonotonicClock& clock)
      : port_(address.arm_port == 0 ? fci::kArmPort : address.arm_port),
        client_(clock, address.host, port_, TimeoutFor(address), address.capture,
                fci::Protocol{request.robot.protocol}),
        kind_(client_.AskForTwin()),
        time_(TimeOf(address, kind_)) {
    if (time_ == backend::RobotTime::kStates) {
      client_.AnswerAgain(std::max(kLongTimeout, address.silence));
    }
    if (request.robot.plant.hand == plant::HandKind::kNone) return;
    const HandDevice device = plant::DeviceOf(request.robot.plant.hand);
    const int after_arm = fci::PortOf(device) - fci::kArmPort;
    hand_.emplace(
        address.host,
        address.hand_port == 0 ? static_cast<std::uint16_t>(port_ + after_arm) : address.hand_port,
        address.capture, device);
  }

  [[nodiscard]] rt::Arrival& arrival() noexcept { return client_.arrival(); }
  [[nodiscard]] std::string WhyLost() const { return client_.WhyLost(); }
  [[nodiscard]] bool is_twin() const noexcept { return kind_ != fci::TwinKind::kNone; }
  [[nodiscard]] backend::RobotTime time() const noexcept { return time_; }
  [[nodiscard]] backend::Hand* hand() noexcept { return hand_ ? &*hand_ : nullptr; }

  [[nodiscard]] backend::Description Describe() const override;
  void Configure(const Setting& setting) override {
    const SetterStatus status = client_.Configure(setting);
    backend::RequireSet(status, setting, mode());
  }
  void Start(const MotionModes& modes) override;
  backend::ReadResult Read(backend::ReadRule rule, RobotState& state,
                           Time& arrival) noexcept override;
  void Write(const RobotCommand& command) noexcept override {
    client_.Send(command);
    // A robot whose states are its clock sends the next state in answer to this command.
    if (time_ == backend::RobotTime::kStates) found_none_ = true;
  }
  void Stop() override;
  /// The robot begins once the arm is at rest, and answers when recovery ends.
  void Recover() override {
    const RecoveryStatus status = client_.Recover();
    backend::RequireRecovered(status, mode());
  }

 private:
  /// As in the last read state.
  [[nodiscard]] RobotMode mode() const noexcept { return mode_.load(std::memory_order_relaxed); }

  const std::uint16_t port_;
  mutable fci::ArmClient client_;
  const fci::TwinKind kind_;
  const backend::RobotTime time_;
  std::optional<FciHand> hand_;

  ObservedMotion motion_;
  std::mutex starting_;                              ///< serialises starting motions
  std::atomic<RobotMode> mode_ = RobotMode::kOther;  ///< for messages only: relaxed

  // Owned by the tick.
  RobotState read_;          ///< a copy, so that the caller's state is written only for kState
  bool found_none_ = false;  ///< the last Read() left the queue empty: the next state is fresh
};

backend::Description FciBackend::Describe() const {
  backend::Description description;
  description.name = "fci";
  description.robot =
      fmt::format("robot at {}, Franka Control Interface {}{}", fci::ToString(client_.robot()),
                  client_.version(), client_.lost() ? ", connection lost" : "");
  if (!motion_.begun()) return description;
  const bool ended = motion_.ended();
  const auto end = client_.AwaitMotionEnd(ended ? kEndTimeout : Duration::zero());
  if (end) description.last_end = backend::EndOf(*end);
  if (!ended) return description;
  // The states show the end, but the robot has not answered.
  if (!end) description.last_end = backend::MotionEnd::kAborted;
  if (description.last_end == backend::MotionEnd::kAborted) {
    description.last_errors = motion_.errors();
  }
  return description;
}

void FciBackend::Start(const MotionModes& modes) {
  const std::lock_guard lock(starting_);
  motion_.Ask(modes);
  MoveStatus status{};
  try {
    status = client_.Move({modes, {}, {}});
  } catch (...) {
    motion_.Refuse();
    throw;
  }
  if (status == MoveStatus::kMotionStarted) {
    motion_.Grant();
    return;
  }
  motion_.Refuse();
  backend::RequireStarted(status, modes, mode());
}

backend::ReadResult FciBackend::Read(backend::ReadRule rule, RobotState& state,
                                     Time& arrival) noexcept {
  Time at{};
  const fci::ReceiveResult result = client_.Receive(read_, at);
  if (result == fci::ReceiveResult::kLost) return backend::ReadResult::kLost;
  const bool may_be_queued = rule == backend::ReadRule::kFresh && !found_none_;
  if (result == fci::ReceiveResult::kState) {
    mode_.store(read_.robot_mode, std::memory_order_relaxed);
    motion_.Observe(read_);
  }
  if (result == fci::ReceiveResult::kPending || may_be_queued) {
    found_none_ = true;  // also after discarding a queued state: the queue is empty
    return backend::ReadResult::kPending;
  }
  found_none_ = false;
  state = read_;
  arrival = at;
  return backend::ReadResult::kState;
}

void FciBackend::Stop() {
  try {
    static_cast<void>(client_.StopMove());  // refused: the motion has already ended
  } catch (const RobotFault&) {
    // No effect without a connection: the robot stops without commands, and Read() reports the
    // loss.
  }
}

}  // namespace

backend::Connection ConnectFci(const backend::Request& request) {
  const auto* remote = std::get_if<backend::RemoteRobot>(&request.time);
  if (remote == nullptr) {
    throw InputError(
        "backend fci is a robot at the other end of a wire, which keeps its own time; say drive: "
        "remote, or backend: mujoco");
  }
  auto backend = std::make_unique<FciBackend>(request, remote->address, remote->clock);
  backend::Connection connection;
  connection.arrival = &backend->arrival();
  connection.hand = backend->hand();
  connection.is_twin = backend->is_twin();
  connection.time = backend->time();
  connection.silence = remote->address.silence;
  connection.why_lost = [&robot = *backend] { return robot.WhyLost(); };
  connection.backend = std::move(backend);
  return connection;
}

void RegisterFci(backend::Registry& registry) {
  registry.Add("fci", &ConnectFci);
}

}  // namespace twin::plugins
