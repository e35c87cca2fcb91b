#include "campaign/session_world.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "campaign/bystanders.h"
#include "campaign/session_path.h"
#include "campaign/wire_client.h"
#include "conformance/dice.h"
#include "conformance/mode_rules.h"
#include "conformance/stream_plan.h"
#include "contract/backend_harness.h"
#include "twin/core/error.h"
#include "twin/run/remote.h"
#include "twin/run/robot_config.h"
#include "twin/scenario/scenario.h"
#include "twin/server/served_robot.h"

namespace twin::campaign {
namespace {

using test::Ask;
using test::Dice;

constexpr std::uint8_t kSuccess = 0;
/// Between a command and the reference that a state shows, in SI units.
constexpr double OffOf(fci::Protocol protocol) {
  return protocol == fci::Protocol::k5 ? 1e-9 : 1e-6;  // an FR3's states are single precision
}
template <typename Status>
std::uint8_t Byte(Status status) {
  return static_cast<std::uint8_t>(status);
}

/// Watches INT itself: its cycles follow one another, whatever clients do.
class CycleWatch final : public record::RecordSink {
 public:
  void Put(const record::CycleRecord& record) noexcept override {
    const std::uint64_t id = record.state.message_id;
    if (last_ && id != *last_ + 1) ++jumps_;
    if (test::FindNotFinite(record.state)) is_finite_ = false;
    last_ = id;
  }
  void Put(const record::TickRecord&) noexcept override {}
  [[nodiscard]] int jumps() const { return jumps_; }
  [[nodiscard]] bool is_finite() const { return is_finite_; }

 private:
  std::optional<std::uint64_t> last_;  ///< id
  std::atomic<int> jumps_ = 0;
  std::atomic<bool> is_finite_ = true;
};

/// What people are told, the motions counted. Threads: any.
class ToldMotions {
 public:
  void Take(std::string_view line) {
    {
      const std::scoped_lock lock(mutex_);
      last_ = line;
    }
    if (!line.starts_with("arm: motion ")) return;
    ++(line.starts_with("arm: motion started") ? begun_ : ended_);
  }
  [[nodiscard]] int begun() const { return begun_; }
  [[nodiscard]] int ended() const { return ended_; }
  [[nodiscard]] std::string last() {
    const std::scoped_lock lock(mutex_);
    return last_;
  }

 private:
  std::mutex mutex_;
  std::string last_;
  std::atomic<int> begun_ = 0;
  std::atomic<int> ended_ = 0;
};

robot::RobotConfig RobotOf(fci::Protocol protocol, robot::PlantKind plant,
                           const run::RunFiles& files) {
  if (protocol == fci::Protocol::k5) return test::HarnessRobot(plant);
  scenario::Scenario scenario = run::DefaultServed();
  scenario.robot.model = "fr3";
  scenario.plant.kind = plant;
  return run::MakeServedConfig(scenario, files);
}

/// One world: a robot, and clients one after the other.
class SessionWorld {
 public:
  SessionWorld(std::uint64_t seed, const run::RunFiles& files)
      // Of dice of their own, as the hand is: other sessions do not depend on them.
      : dice_(seed),
        is_mujoco_(Dice(seed + (1ULL << 40)).Chance(0.25)),
        protocol_(Dice(seed + (1ULL << 41)).Chance(1.0 / 3) ? fci::Protocol::k10
                                                            : fci::Protocol::k5) {
    robot::RobotConfig config = RobotOf(
        protocol_, is_mujoco_ ? robot::PlantKind::kMujoco : robot::PlantKind::kIdeal, files);
    config.onboard.collision_behavior = scenario::NoCollisionBehavior();
    config.plant.hand =
        Dice(~seed).Chance(0.25) ? plant::HandKind::kCobotPump : plant::HandKind::kFrankaHand;
    server::ServedRobotSettings settings{.takes_free_ports = true, .sink = &watch_};
    settings.tell = [this](std::string_view line) { told_.Take(line); };
    // Longer than any client's patience: the server itself has to end what a client leaves.
    settings.lockstep = {.answer_timeout = std::chrono::minutes(1), .freeze_when_idle = true};
    settings.thread = rt::ThreadSettings{.name = "robot", .lock_memory = false};
    service_.emplace(config, robot::MakePlant(config), settings);
    service_->Start();
    bystanders_.emplace(dice_, *service_, plant::DeviceOf(config.plant.hand));
  }

  Outcome Run() {
    Outcome outcome;
    try {
      for (int clients = dice_.Whole(1, 4); clients > 0; --clients) ServeOne();
      outcome.end = "sessions";
    } catch (const BrokenPromise& broken) {
      outcome.finding = Finding{"session", WithStory(broken.what())};
    } catch (const Error& error) {
      outcome.finding = Finding{"errors", WithStory(error.what())};
    }
    const int ways_back = bystanders_->ways_back();
    bystanders_.reset();
    service_->End();
    if (outcome.finding) return outcome;
    if (watch_.jumps() > ways_back) {
      outcome.finding = Finding{"ids", "INT's cycles do not follow one another"};
    }
    if (!watch_.is_finite()) outcome.finding = Finding{"finite", "a state of INT's is not"};
    // Of one that was left nobody may be told any more.
    if (told_.begun() != motions_ || told_.ended() < motions_ - (left_moving_ ? 1 : 0)) {
      outcome.finding = Finding{"session", fmt::format("of {} motions {} are told, and {} ends",
                                                       motions_, told_.begun(), told_.ended())};
    }
    return outcome;
  }

 private:
  void Note(std::string what) { done_.push_back(std::move(what)); }
  [[nodiscard]] std::string WithStory(std::string_view what) {
    return fmt::format("{}; people were told last: {}; after: {}", what, told_.last(),
                       fmt::join(done_, ", "));
  }

  static void Require(bool holds, std::string_view promise, std::uint8_t status) {
    if (!holds) throw BrokenPromise(fmt::format("{}, status {}", promise, status));
  }

  /// Whether the robot does this when asked now; by the table of requests and modes.
  [[nodiscard]] bool Grants(Ask ask) const { return Expect(now_, ask).accepted; }

  void ServeOne() {
    client_.emplace(service_->arm(), protocol_);
    motion_.reset();
    Note("connect");
    if (dice_.Chance(0.1)) return RefuseOpening();
    const std::uint8_t status = client_->Ask(client_->Hello());
    Require(status == kSuccess, "Connect in order is refused", status);
    const auto first = client_->AwaitState(0, std::chrono::seconds(20));
    if (!first) throw BrokenPromise("no state after Connect");
    if (first->robot_mode != now_.mode &&
        !(left_moving_ && first->robot_mode == RobotMode::kIdle)) {
      throw BrokenPromise(
          fmt::format("the robot is in mode {}, not {}", Name(first->robot_mode), Name(now_.mode)));
    }
    now_.mode = first->robot_mode;
    left_moving_ = false;
    for (int i = dice_.Whole(0, 12); i > 0; --i) Act();
    Leave();
  }

  /// Another version, or another request than Connect, ends the connection.
  void RefuseOpening() {
    if (dice_.Chance(0.5)) {
      Note("another version");
      fci::Connect hello = client_->Hello();
      const auto other = static_cast<std::uint16_t>(15 - hello.version);  // 10 for 5
      hello.version = dice_.Chance(0.5) ? other : static_cast<std::uint16_t>(dice_.Whole(0, 4));
      const std::uint8_t status = client_->Ask(hello);
      Require(status != kSuccess, "another version is taken", status);
    } else {
      Note("a request before Connect");
      std::vector<std::byte> bytes;
      client_->Frame(fci::StopMove(), bytes);
      client_->Send(bytes);
    }
    client_->AwaitClosed();
  }

  void Act() {
    const int kind = dice_.Whole(0, 12);
    if (kind >= 10) {
      // In a motion time waits for this client; MuJoCo's arm may still brake after an abort.
      const bool is_busy =
          now_.mode == RobotMode::kMove || (is_mujoco_ && now_.mode == RobotMode::kReflex);
      if (!is_busy) bystanders_->Act(now_, done_);
      return;
    }
    if (kind <= 3) return AskSeveral();
    if (kind == 4) return SendJunk();
    if (kind == 5) return TrySecondClient();
    if (kind == 6) return AskForRecovery();
    Move();
  }

  // --- Requests whose answer does not wait for the robot

  struct Asked {
    std::uint32_t id = 0;
    std::string name;
    std::vector<std::uint8_t> allowed;
  };

  Asked DrawRequest(std::vector<std::byte>& bytes) {
    switch (dice_.Whole(0, 4)) {
      case 0: {
        if (protocol_ == fci::Protocol::k10) {
          return {client_->Frame(fci::GetRobotModel(), bytes), "robot model", {kSuccess}};
        }
        const auto id = static_cast<std::int32_t>(dice_.Whole(-3, 10));
        return {client_->Frame(fci::GetCartesianLimit{id}, bytes), "limit", {kSuccess}};
      }
      case 1: {  // none is served
        if (protocol_ == fci::Protocol::k10) break;
        const fci::LoadModelLibrary machine{static_cast<fci::Architecture>(dice_.Whole(0, 5)),
                                            static_cast<fci::OperatingSystem>(dice_.Whole(0, 3))};
        return {client_->Frame(machine, bytes), "library", {Byte(fci::ModelLibraryStatus::kError)}};
      }
      case 2:
        if (now_.mode == RobotMode::kMove) break;  // its answer waits for the arm
        return {client_->Frame(fci::StopMove(), bytes), "stop", {kSuccess}};
      case 3:
        if (now_.mode != RobotMode::kMove) break;  // it would start one
        return {client_->Frame(DrawMove(), bytes),
                "move in motion",
                {Byte(MoveStatus::kCommandNotPossibleRejected)}};
      default: break;
    }
    Setting setting = test::DrawSetting(static_cast<std::uint64_t>(dice_.Whole(0, 1 << 30)));
    if (protocol_ == fci::Protocol::k10 && std::holds_alternative<setting::Filters>(setting)) {
      setting = setting::GuidingMode();
    }
    const bool is_bad = FindBadValue(setting).has_value();
    // With other thresholds, a load that is not there would be a collision.
    if (!is_bad && std::holds_alternative<setting::CollisionBehavior>(setting)) {
      setting = scenario::NoCollisionBehavior();
    }
    // INT would hold up a load that MuJoCo's arm does not carry.
    if (!is_bad && is_mujoco_ && std::holds_alternative<setting::Load>(setting)) {
      setting = setting::Load();
    }
    is_filtered_ = is_filtered_ || std::holds_alternative<setting::Filters>(setting);
    const auto invalid = Byte(SetterStatus::kInvalidArgumentRejected);
    const auto impossible = Byte(SetterStatus::kCommandNotPossibleRejected);
    Asked asked{client_->Frame(setting, bytes), std::string(Name(setting)), {}};
    if (!Grants(Ask::kSet)) asked.allowed.push_back(impossible);
    if (is_bad) asked.allowed.push_back(invalid);
    if (asked.allowed.empty()) asked.allowed.push_back(kSuccess);
    return asked;
  }

  /// Many at once, in pieces: each gets its answer, in order.
  void AskSeveral() {
    std::vector<std::byte> bytes;
    std::vector<Asked> asked;
    for (int i = dice_.Whole(1, 6); i > 0; --i) asked.push_back(DrawRequest(bytes));
    std::vector<std::size_t> cuts;
    for (int i = dice_.Whole(0, 5); i > 0; --i) {
      cuts.push_back(static_cast<std::size_t>(dice_.Whole(1, static_cast<int>(bytes.size()))));
    }
    std::ranges::sort(cuts);
    for (const Asked& one : asked) Note(one.name);
    const std::size_t answered = client_->answered().size();
    client_->Send(bytes, cuts);
    for (const Asked& one : asked) {
      const std::uint8_t status = client_->AwaitAnswer(one.id);
      Require(std::ranges::find(one.allowed, status) != one.allowed.end(),
              fmt::format("{} in mode {}", one.name, Name(now_.mode)), status);
    }
    for (std::size_t i = 0; i < asked.size(); ++i) {
      if (client_->answered()[answered + i] == asked[i].id) continue;
      throw BrokenPromise("answers come in another order than requests");
    }
  }

  void AskForRecovery() {
    Note("recovery");
    const std::uint8_t status = client_->Ask(fci::AutomaticErrorRecovery());
    Require((status == kSuccess) == Grants(Ask::kAutomaticErrorRecovery),
            fmt::format("recovery in mode {}", Name(now_.mode)), status);
    if (status != kSuccess || !now_.has_errors) return;
    now_ = {};
  }

  /// Datagrams that are no commands have no effect.
  void SendJunk() {
    Note("junk datagrams");
    for (int i = dice_.Whole(1, 20); i > 0; --i) {
      std::vector<std::byte> bytes(static_cast<std::size_t>(dice_.Whole(0, 500)));
      for (std::byte& byte : bytes) byte = static_cast<std::byte>(dice_.Whole(0, 255));
      // Of a command's size only one for a state that was never sent.
      if (bytes.size() >= 8) std::fill_n(bytes.begin(), 8, std::byte{0xff});
      client_->SendDatagram(bytes);
    }
  }

  /// While one is served another is turned away, and the first one notices nothing.
  void TrySecondClient() {
    Note("a second client");
    WireClient other(service_->arm(), protocol_);
    std::vector<std::byte> bytes;
    other.Frame(other.Hello(), bytes);
    other.Send(bytes);
    other.AwaitClosed();
  }

  // --- Motions

  fci::Move DrawMove() {
    fci::Move move;
    move.modes = {static_cast<ControllerMode>(dice_.Whole(0, 2)),
                  static_cast<MotionGeneratorMode>(dice_.Whole(1, 4))};
    const bool is_torque = move.modes.controller == ControllerMode::kExternalController;
    if (protocol_ == fci::Protocol::k10 && is_torque && dice_.Chance(0.5)) {
      move.modes.generator = MotionGeneratorMode::kNone;
    }
    return move;
  }

  void Move() {
    fci::Move move = DrawMove();
    bool is_bad = false;
    if (dice_.Chance(0.1)) {
      is_bad = true;
      move.modes.controller = ControllerMode::kOther;
    } else if (dice_.Chance(0.1)) {
      is_bad = true;
      move.maximum_path_deviation.rotation = std::numeric_limits<double>::quiet_NaN();
    }
    Note(fmt::format("move {} {}", Name(move.modes.generator), Name(move.modes.controller)));
    std::vector<std::byte> bytes;
    const std::uint32_t id = client_->Frame(move, bytes);
    client_->Send(bytes);
    const auto status = static_cast<MoveStatus>(client_->AwaitAnswer(id));
    const bool starts = status == MoveStatus::kMotionStarted;
    Require(starts == (Grants(Ask::kMove) && !is_bad),
            fmt::format("Move in mode {}", Name(now_.mode)), Byte(status));
    if (!starts) return;
    motion_ = id;
    ++motions_;
    client_->OweEnd(id);
    RunMotion(move.modes);
  }

  /// The state that a motion's start shows in.
  RobotState AwaitMove() {
    std::uint64_t last = 0;
    for (int i = 0; i < 1000; ++i) {
      const auto state = client_->AwaitState(last, std::chrono::seconds(20));
      if (!state) break;
      if (state->robot_mode == RobotMode::kMove) return *state;
      last = state->message_id;
    }
    throw BrokenPromise("a started motion does not show in a state");
  }

  /// Answers until the robot has taken the answer. @returns the state that came of it.
  RobotState Answer(const RobotState& state, RobotCommand command) {
    RobotState shown = state;
    for (int i = 0; i < 200; ++i) {
      command.message_id = shown.message_id;
      client_->Command(command);
      // One that crosses with a state sent again is lost.
      if (const auto next = client_->AwaitState(shown.message_id, std::chrono::milliseconds(100))) {
        const bool is_again = !has_begun_ && next->robot_mode == RobotMode::kMove &&
                              next->control_command_success_rate == 0;
        shown = *next;
        if (is_again) continue;
        has_begun_ = true;
        return shown;
      }
    }
    throw BrokenPromise("the robot does not go on after an answer");
  }

  void RunMotion(const MotionModes& modes) {
    now_.mode = RobotMode::kMove;
    has_begun_ = false;
    RobotState state = AwaitMove();
    const SessionPath path(dice_, state, modes);
    const int all = dice_.Chance(0.7) ? path.cycles() : dice_.Whole(1, path.cycles());
    for (int k = 1; k <= all; ++k) {
      state = Answer(state, path.At(state, k));
      if (state.robot_mode != RobotMode::kMove) {
        throw BrokenPromise(fmt::format("cycle {} of {} of a gentle motion is its last: {}", k,
                                        path.cycles(), FormatErrors(state.reflex_reason)));
      }
      if (const double off = path.Off(state, k); !is_filtered_ && off > OffOf(protocol_)) {
        throw BrokenPromise(
            fmt::format("after {} of {} commands the reference is off its path by "
                        "{:.3g}",
                        k, path.cycles(), off));
      }
      if (dice_.Chance(0.1)) AskSeveral();
      if (dice_.Chance(0.05)) SendJunk();
      if (dice_.Chance(0.03)) TrySecondClient();
      if (dice_.Chance(0.03)) AskForRecovery();
    }
    EndMotion(path, all, state);
  }

  /// @param k  commands so far.
  void EndMotion(const SessionPath& path, int k, const RobotState& state) {
    switch (dice_.Whole(0, 3)) {
      case 0: {
        Note("finish");
        // As long as it is in motion it waits for answers.
        RobotState now = state;
        while (now.robot_mode == RobotMode::kMove) {
          RobotCommand next = path.At(now, ++k);
          next.motion_generation_finished = k > path.cycles();
          now = Answer(now, next);
        }
        return AwaitEnd(MoveStatus::kSuccess, RobotMode::kIdle);
      }
      case 1: {
        Note("stop");
        const std::uint8_t status = client_->Ask(fci::StopMove());
        Require(status == kSuccess, "StopMove of a motion", status);
        return AwaitEnd(MoveStatus::kPreempted, RobotMode::kIdle);
      }
      case 2: {
        Note("step");
        RobotCommand step = path.At(state, k + 1);
        step.q_c[0] += 1;
        step.dq_c[0] += 10;
        step.O_T_EE_c[12] += 1;
        step.O_dP_EE_c[0] += 10;
        step.tau_J_d[0] += 1000;
        static_cast<void>(Answer(state, step));
        return AwaitEnd(MoveStatus::kReflexAborted, RobotMode::kReflex);
      }
      default: return;  // the client leaves in motion
    }
  }

  void AwaitEnd(MoveStatus end, RobotMode mode) {
    const auto status = static_cast<MoveStatus>(client_->AwaitAnswer(*motion_));
    Require(status == end, fmt::format("a motion that should end with status {}", Byte(end)),
            Byte(status));
    motion_.reset();
    now_.mode = mode;
    now_.has_errors = mode == RobotMode::kReflex;
  }

  void Leave() {
    left_moving_ = motion_.has_value();
    switch (dice_.Whole(0, 2)) {
      case 0:
        Note("close");
        client_->Close();
        break;
      case 1:
        Note("reset");
        client_->Reset();
        break;
      default: {
        Note("malformed frame");
        std::vector<std::byte> bytes;
        client_->Frame(DrawMove(), bytes);
        bytes[8] =
            static_cast<std::byte>(dice_.Whole(0, static_cast<int>(bytes.size()) - 1));  // its size
        client_->Send(bytes);
        client_->AwaitClosed();
      }
    }
    if (left_moving_) now_.mode = RobotMode::kIdle;  // the server stops the motion
  }

  Dice dice_;
  const bool is_mujoco_;
  const fci::Protocol protocol_;
  CycleWatch watch_;
  ToldMotions told_;
  std::optional<server::ServedRobot> service_;
  std::optional<Bystanders> bystanders_;  ///< from service_'s start to its end
  std::optional<WireClient> client_;
  std::vector<std::string> done_;
  test::Situation now_;
  std::optional<std::uint32_t> motion_;  ///< command_id of the running motion's Move
  bool is_filtered_ = false;             ///< INT may smooth commands
  int motions_ = 0;                      ///< that were started
  bool has_begun_ = false;               ///< the motion's first command was taken
  bool left_moving_ = false;             ///< the last client left in motion
};

}  // namespace

Outcome RunSessionWorld(std::uint64_t seed, const run::RunFiles& files) {
  return SessionWorld(seed, files).Run();
}

}  // namespace twin::campaign
