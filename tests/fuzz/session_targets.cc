#include "fuzz/session_targets.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "twin/core/error.h"
#include "twin/fci/arm_session.h"
#include "twin/fci/frame_reader.h"
#include "twin/fci/hand_session.h"
#include "twin/fci/protocol.h"
#include "twin/fci/requests.h"

namespace twin::fci::fuzz {
namespace {

constexpr std::uint8_t kFirstEvent = 0xC0;
constexpr std::size_t kLibraryBytes = 9;  ///< of the model library; what is in it does not matter
constexpr std::size_t kLargestAnswer = 1024;

/// The script's steps, one after the other.
class Script {
 public:
  explicit Script(Bytes script) : rest_(script) {}

  struct Step {
    Bytes segment;                      ///< empty with an event
    std::optional<std::uint8_t> event;  ///< counted from 0
  };
  [[nodiscard]] std::optional<Step> Next() {
    if (rest_.empty()) return {};
    const auto first = static_cast<std::uint8_t>(rest_.front());
    rest_ = rest_.subspan(1);
    if (first >= kFirstEvent) return Step{{}, static_cast<std::uint8_t>(first - kFirstEvent)};
    const Bytes segment = rest_.first(std::min(rest_.size(), std::size_t{first} + 1));
    rest_ = rest_.subspan(segment.size());
    return Step{segment, {}};
  }

 private:
  Bytes rest_;
};

/// The requests that were not answered to their end, and the rules for what is answered.
class Waiting {
 public:
  explicit Waiting(HeadKind kind) : kind_(kind) {}

  void Ask(const FrameHead& head) {
    ++tally_.requests;
    waiting_.push_back({head.command, head.command_id});
  }

  /// The session gave these bytes away.
  void Answer(std::span<const std::byte> bytes) {
    TWIN_CHECK(!over_);
    ++tally_.answers;
    FrameReader reader(kind_, kLargestAnswer);
    std::copy(bytes.begin(), bytes.end(), reader.Room().begin());
    reader.Received(bytes.size());
    const auto frame = reader.Next();
    TWIN_CHECK(frame.has_value());
    TWIN_CHECK(!reader.is_inside_frame());
    kind_ == HeadKind::kArm ? TakeArm(*frame) : TakeHand(*frame);
  }

  /// Nothing may be answered any more.
  void End(bool asked_for) {
    over_ = true;
    tally_.ended = asked_for;
  }

  [[nodiscard]] std::size_t count() const { return waiting_.size(); }
  [[nodiscard]] const SessionTally& tally() const { return tally_; }

 private:
  struct Request {
    std::uint32_t command = 0;
    std::uint32_t command_id = 0;
    bool runs = false;  ///< a motion that was said to have started
  };

  void TakeArm(const Frame& frame) {
    const auto command = static_cast<ArmCommand>(frame.head.command);
    const auto parsed = ParseArmAnswer(command, frame);
    TWIN_CHECK(std::holds_alternative<ArmAnswer>(parsed));
    const std::uint8_t status = std::get<ArmAnswer>(parsed).status;
    const bool is_move = command == ArmCommand::kMove;
    const bool starts = is_move && status == static_cast<std::uint8_t>(MoveStatus::kMotionStarted);
    // A motion's end answers the Move that runs, everything else one that was not answered yet.
    const bool ends = is_move && !starts && !IsRejection(static_cast<MoveStatus>(status));
    if (ends) TWIN_CHECK(!AnyOf(ArmCommand::kStopMove));  // they are told before
    const auto place = Find(frame.head, ends);
    TWIN_CHECK(place.has_value());
    if (starts) {
      waiting_[*place].runs = true;
    } else {
      Erase(*place);
    }
  }

  void TakeHand(const Frame& frame) {
    const auto asked = static_cast<HandCommandId>(frame.head.command);
    TWIN_CHECK(std::holds_alternative<HandAnswer>(ParseHandAnswer(asked, frame)));
    const auto place = Find(frame.head, false);
    TWIN_CHECK(place.has_value());
    Erase(*place);
  }

  [[nodiscard]] static bool IsRejection(MoveStatus status) {
    return status >= MoveStatus::kCommandNotPossibleRejected &&
           status <= MoveStatus::kInvalidArgumentRejected;
  }
  [[nodiscard]] std::optional<std::size_t> Find(const FrameHead& head, bool runs) const {
    for (std::size_t i = 0; i < waiting_.size(); ++i) {
      const Request& one = waiting_[i];
      if (one.command == head.command && one.command_id == head.command_id && one.runs == runs) {
        return i;
      }
    }
    return {};
  }
  [[nodiscard]] bool AnyOf(ArmCommand command) const {
    return std::ranges::any_of(waiting_, [command](const Request& one) {
      return one.command == static_cast<std::uint32_t>(command);
    });
  }
  void Erase(std::size_t i) { waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(i)); }

  const HeadKind kind_;
  std::vector<Request> waiting_;
  SessionTally tally_;
  bool over_ = false;
};

/// An arm that grants and refuses as INT does, moved on by events.
class ScriptedArm final : public ArmService {
 public:
  void Do(ArmEvent event) {
    switch (event) {
      case ArmEvent::kMotionFinishes: return EndMotion(MoveStatus::kSuccess, RobotMode::kIdle);
      case ArmEvent::kMotionIsAborted:
        return EndMotion(MoveStatus::kReflexAborted, RobotMode::kReflex);
      case ArmEvent::kMotionIsStopped: return EndMotion(MoveStatus::kPreempted, RobotMode::kIdle);
      case ArmEvent::kComesToRest: rests_ = rests_ || mode_ != RobotMode::kMove; return;
      case ArmEvent::kRecovers:
        if (mode_ == RobotMode::kAutomaticErrorRecovery) mode_ = RobotMode::kIdle;
        return;
      case ArmEvent::kUserStops:
        EndMotion(MoveStatus::kEmergencyAborted, RobotMode::kUserStopped);
        mode_ = RobotMode::kUserStopped;
        return;
      case ArmEvent::kUserLets:
        if (mode_ == RobotMode::kUserStopped) mode_ = RobotMode::kIdle;
        return;
    }
  }

  [[nodiscard]] MoveStatus Move(const fci::Move& move) override {
    const bool exists = move.modes.controller != ControllerMode::kOther &&
                        move.modes.generator != MotionGeneratorMode::kIdle;
    if (!exists) return MoveStatus::kInvalidArgumentRejected;
    if (mode_ != RobotMode::kIdle || !rests_) return MoveStatus::kCommandNotPossibleRejected;
    mode_ = RobotMode::kMove;
    last_end_ = MoveStatus::kMotionStarted;
    stop_asked_ = false;
    return MoveStatus::kMotionStarted;
  }
  void StopMove() override { stop_asked_ = true; }
  [[nodiscard]] SetterStatus Configure(const Setting& setting) override {
    if (FindBadValue(setting)) return SetterStatus::kInvalidArgumentRejected;
    return mode_ == RobotMode::kIdle ? SetterStatus::kSuccess
                                     : SetterStatus::kCommandNotPossibleRejected;
  }
  [[nodiscard]] RecoveryStatus Recover() override {
    if (mode_ == RobotMode::kIdle) return RecoveryStatus::kSuccess;
    if (mode_ != RobotMode::kReflex || !rests_) return RecoveryStatus::kCommandNotPossibleRejected;
    mode_ = RobotMode::kAutomaticErrorRecovery;
    return RecoveryStatus::kSuccess;
  }
  [[nodiscard]] SetterStatus CartesianLimitOf(std::int32_t id, CartesianLimit& limit) override {
    limit = {};
    return id < 0 ? SetterStatus::kInvalidArgumentRejected : SetterStatus::kSuccess;
  }
  [[nodiscard]] std::string_view RobotModel() override { return "<robot/>"; }
  [[nodiscard]] std::span<const std::byte> ModelLibrary(const LoadModelLibrary& machine) override {
    const bool is_there = machine.architecture == Architecture::kX64;
    return std::span(library_).first(is_there ? library_.size() : 0);
  }
  [[nodiscard]] ArmProgress Progress() override {
    return {mode_, mode_ == RobotMode::kMove, last_end_};
  }

  [[nodiscard]] bool moves_on() const { return mode_ == RobotMode::kMove && !stop_asked_; }

 private:
  void EndMotion(MoveStatus end, RobotMode mode) {
    if (mode_ != RobotMode::kMove) return;
    mode_ = mode;
    last_end_ = end;
    rests_ = end == MoveStatus::kSuccess;
  }

  RobotMode mode_ = RobotMode::kIdle;
  MoveStatus last_end_ = MoveStatus::kMotionStarted;
  bool rests_ = true;
  bool stop_asked_ = false;
  const std::array<std::byte, kLibraryBytes> library_{};
};

/// A hand that does one thing at a time, until an event ends it.
class ScriptedHand final : public HandService {
 public:
  void Do(HandResult how) {
    if (runs_) ended_ = how;
    runs_ = false;
  }

  [[nodiscard]] HandStart Start(const HandCommand& command) override {
    if (auto bad = FindBadValue(command, 0)) return {0, bad};
    before_ = runs_ ? HandResult::kAborted : ended_;
    runs_ = !std::holds_alternative<hand::Stop>(command);
    ended_ = HandResult::kSuccess;
    return {++ticket_, {}};
  }
  [[nodiscard]] std::optional<HandResult> Outcome(HandTicket ticket) override {
    TWIN_CHECK(ticket > 0);
    TWIN_CHECK(ticket <= ticket_);
    if (ticket < ticket_) return before_;
    return runs_ ? std::nullopt : std::optional(ended_);
  }

 private:
  HandTicket ticket_ = 0;
  bool runs_ = false;
  HandResult ended_ = HandResult::kSuccess;   ///< of the last command
  HandResult before_ = HandResult::kSuccess;  ///< of those before
};

/// Gives a script to a session. @param Session  ArmSession or HandSession.
/// @param on_event  lets the robot do something, and tells the session.
/// @param on_step   after each frame and each event.
/// @returns whether the session asked for the connection's end.
template <typename Session, typename OnEvent, typename OnStep>
bool Play(Bytes bytes, HeadKind kind, std::size_t largest, Session& session, Waiting& waiting,
          const OnEvent& on_event, const OnStep& on_step) {
  Script script(bytes);
  FrameReader reader(kind, largest);
  while (const auto step = script.Next()) {
    if (step->event) {
      on_event(*step->event);
      on_step();
      continue;
    }
    Bytes rest = step->segment;
    while (!rest.empty()) {
      const auto room = reader.Room();
      const std::size_t count = std::min(room.size(), rest.size());
      std::copy_n(rest.begin(), count, room.begin());
      reader.Received(count);
      rest = rest.subspan(count);
      while (const auto frame = reader.Next()) {
        waiting.Ask(frame->head);
        if (const auto why = session.OnFrame(*frame)) {
          TWIN_CHECK(!why->empty());
          return true;
        }
        on_step();
      }
      if (reader.fault() != nullptr) return true;
    }
  }
  return false;
}

/// What holds after each frame that did not end the session, and after each event.
template <typename Session>
void CheckBetween(const Session& session, const Waiting& waiting, std::size_t most) {
  TWIN_CHECK(waiting.tally().requests == 0 || session.udp_port().value_or(0) != 0);
  TWIN_CHECK(session.has_pending() == (waiting.count() > 0));
  TWIN_CHECK(waiting.count() <= most);
}

/// StopMoves that wait at once, and a Move and a recovery beside them.
constexpr std::size_t kMostWaiting = 64 + 2;

}  // namespace

SessionTally RunArmSession(Bytes script) {
  ScriptedArm arm;
  Waiting waiting(HeadKind::kArm);
  fci::ArmSession session(arm, [&](std::span<const std::byte> bytes) { waiting.Answer(bytes); });
  const auto happens = [&](ArmEvent event) {
    arm.Do(event);
    session.OnProgress(arm.Progress());
  };
  const bool ended = Play(
      script, HeadKind::kArm, kLargestArmRequest, session, waiting,
      [&](std::uint8_t event) { happens(static_cast<ArmEvent>(event % kArmEvents)); },
      [&] { CheckBetween(session, waiting, kMostWaiting); });
  if (!ended) {
    happens(ArmEvent::kMotionIsStopped);
    happens(ArmEvent::kUserLets);
    happens(ArmEvent::kComesToRest);
    happens(ArmEvent::kRecovers);
    TWIN_CHECK(waiting.count() == 0);
    TWIN_CHECK(!session.has_pending());
  }
  waiting.End(ended);
  session.OnClosed();
  TWIN_CHECK(!arm.moves_on());
  TWIN_CHECK(!session.has_pending());
  session.OnProgress(arm.Progress());
  return waiting.tally();
}

SessionTally RunHandSession(Bytes script) {
  ScriptedHand hand;
  Waiting waiting(HeadKind::kHand);
  fci::HandSession session(hand, [&](std::span<const std::byte> bytes) { waiting.Answer(bytes); });
  const auto happens = [&](HandResult how) {
    hand.Do(how);
    session.OnProgress();
  };
  const bool ended = Play(
      script, HeadKind::kHand, kLargestHandRequest, session, waiting,
      [&](std::uint8_t event) { happens(static_cast<HandResult>(event % kHandEvents)); },
      [&] { CheckBetween(session, waiting, 1); });
  if (!ended) {
    happens(HandResult::kSuccess);
    TWIN_CHECK(waiting.count() == 0);
    TWIN_CHECK(!session.has_pending());
  }
  waiting.End(ended);
  return waiting.tally();
}

void ArmSession(Bytes data) {
  RunArmSession(data);
}

void HandSession(Bytes data) {
  RunHandSession(data);
}

void Gripper(Bytes data) {
  if (data.empty()) return;
  constexpr Target kParts[] = {HandSession, HandAnswers, HandStateDatagram};
  kParts[static_cast<unsigned>(data.front()) % 3](data.subspan(1));
}

}  // namespace twin::fci::fuzz
