#include "campaign/bystanders.h"

#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "campaign/wire_client.h"
#include "twin/core/error.h"

namespace twin::campaign {
namespace {

using server::ControlRequest;
using server::ControlVerb;
using test::Ask;

/// Long enough for a busy machine.
constexpr fci::ClientTimeout kPatience{std::chrono::seconds(20), std::chrono::seconds(20),
                                       std::chrono::seconds(20)};

/// Of the robot's time, while a command to the hand runs: a dozen of the hand's states.
constexpr std::uint64_t kStep = 250;

/// Unix sockets have a name of their own, in one process, too.
std::filesystem::path NewSocket() {
  static std::atomic<int> count = 0;
  return std::filesystem::temp_directory_path() /
         fmt::format("panda_twin_campaign_{}_{}", getpid(), ++count);
}

[[noreturn]] void Break(const std::string& text) {
  throw BrokenPromise(text);
}

/// Whether a command may end so where there is nothing to hold.
bool MayEnd(const HandCommand& command, HandResult result) {
  if (std::holds_alternative<hand::Vacuum>(command)) return result == HandResult::kUnsuccessful;
  const auto* const grasp = std::get_if<hand::Grasp>(&command);
  if (grasp == nullptr) return result == HandResult::kSuccess;
  // The fingers go to the end of their way, to a millimetre, which is right for what is that thin
  // or wide.
  if (result == HandResult::kUnsuccessful) return grasp->width > grasp->epsilon_inner - 1e-3;
  return result == HandResult::kSuccess &&
         (grasp->width < grasp->epsilon_inner + 1e-3 ||
          grasp->width > kHandStroke - grasp->epsilon_outer - 1e-3);
}

}  // namespace

Bystanders::Bystanders(test::Dice& dice, server::ServedRobot& robot, HandDevice device)
    : dice_(dice),
      robot_(robot),
      device_(device),
      may_reset_(dice.Chance(0.5)),
      controlled_(robot, may_reset_),
      socket_(NewSocket()),
      channel_(socket_, controlled_, [](auto&&...) {}) {}

void Bystanders::Act(test::Situation& now, std::vector<std::string>& done) {
  if (dice_.Chance(0.4)) {
    done.push_back(UseHand());
    return;
  }
  const ControlRequest request = DrawRequest();
  done.push_back(server::ToLine(request));
  switch (request.verb) {
    case ControlVerb::kUserStop:
      return Operate(request, request.on ? Ask::kPressUserStop : Ask::kReleaseUserStop, now);
    case ControlVerb::kGuiding:
      return Operate(request, request.on ? Ask::kPressGuidingButton : Ask::kReleaseGuidingButton,
                     now);
    case ControlVerb::kRecover: return Operate(request, Ask::kAutomaticErrorRecovery, now);
    case ControlVerb::kReset: return Reset(request, now);
    case ControlVerb::kSnapshot: return Keep(request, now);
    case ControlVerb::kRestore: return GoBack(request, now);
    case ControlVerb::kPlace: return Refuse(request);  // there is no object
    default: return Step(request, now);
  }
}

ControlRequest Bystanders::DrawRequest() {
  static constexpr std::array kVerbs{
      ControlVerb::kStep,  ControlVerb::kUserStop, ControlVerb::kGuiding, ControlVerb::kRecover,
      ControlVerb::kReset, ControlVerb::kSnapshot, ControlVerb::kRestore, ControlVerb::kPlace};
  ControlRequest request{.verb =
                             kVerbs[static_cast<std::size_t>(dice_.Whole(0, kVerbs.size() - 1))]};
  request.cycles = static_cast<std::uint64_t>(dice_.Whole(1, 300));
  request.on = dice_.Chance(0.5);
  request.name = dice_.Chance(0.5) ? ControlRequest::kSnapshot : "other";
  return request;
}

nlohmann::json Bystanders::Ask(const ControlRequest& request) {
  const std::string line = server::AskControl(socket_, request);
  auto answer = nlohmann::json::parse(line, nullptr, false);
  if (answer.is_discarded() || !answer.contains("ok")) {
    Break("no answer of a control channel: " + line);
  }
  return answer;
}

std::uint64_t Bystanders::Do(const ControlRequest& request) {
  const nlohmann::json answer = Ask(request);
  if (answer["ok"]) return answer["cycle"];
  Break(fmt::format("{} is refused: {}", server::ToLine(request), answer.dump()));
}

void Bystanders::Refuse(const ControlRequest& request) {
  if (Ask(request)["ok"]) Break(server::ToLine(request) + " is not refused");
}

void Bystanders::Step(const ControlRequest& step, const test::Situation& now) {
  Refuse(step);  // time runs
  const std::uint64_t begin = Do({.verb = ControlVerb::kPause});
  const std::uint64_t end = Do(step);
  const nlohmann::json after = Ask({});
  if (end != begin + step.cycles || after["cycle"] != end || after["mode"] != Name(now.mode)) {
    Break(fmt::format("{} cycles from {} in mode {} end at {}, then {}", step.cycles, begin,
                      Name(now.mode), end, after.dump()));
  }
  Do({.verb = ControlVerb::kResume});
}

void Bystanders::Operate(const ControlRequest& request, test::Ask ask, test::Situation& now) {
  const test::Outcome expected = Expect(now, ask);
  if (!expected.accepted) return Refuse(request);
  Do(request);
  const bool recovers = expected.mode == RobotMode::kAutomaticErrorRecovery;
  now.mode = recovers ? RobotMode::kIdle : expected.mode;
  if (recovers) now.has_errors = false;
  const nlohmann::json after = Ask({});
  if (after["mode"] != Name(now.mode)) {
    Break(fmt::format("not {}: {}", Name(now.mode), after.dump()));
  }
  // MuJoCo's arm brakes first once it is let go, and no motion begins before it rests.
  if (ask == Ask::kReleaseGuidingButton) Step({.verb = ControlVerb::kStep, .cycles = kStep}, now);
}

void Bystanders::Reset(const ControlRequest& reset, test::Situation& now) {
  const nlohmann::json answer = Ask(reset);
  if (!answer["ok"]) {
    if (may_reset_ && !may_be_busy_) Break("a reset is refused: " + answer.dump());
    return;
  }
  now = {};
  if (!may_reset_ || answer["mode"] != Name(now.mode) || !answer["errors"].empty()) {
    Break("a reset: " + answer.dump());
  }
}

void Bystanders::Keep(const ControlRequest& snapshot, const test::Situation& now) {
  Do({.verb = ControlVerb::kPause});
  const nlohmann::json answer = Ask(snapshot);
  if (answer["ok"]) {
    snapshots_[snapshot.name] = {answer["cycle"], now};
  } else if (!may_be_busy_) {
    Break("a snapshot is refused: " + answer.dump());
  }
  Do({.verb = ControlVerb::kResume});
}

void Bystanders::GoBack(const ControlRequest& restore, test::Situation& now) {
  const auto kept = snapshots_.find(restore.name);
  if (kept == snapshots_.end()) return Refuse(restore);
  Do({.verb = ControlVerb::kPause});
  const nlohmann::json answer = Ask(restore);
  if (answer["ok"]) {
    now = kept->second.now;
    ++ways_back_;
    if (answer["cycle"] != kept->second.cycle || answer["mode"] != Name(now.mode)) {
      Break(fmt::format("a snapshot of cycle {} in mode {} comes back as {}", kept->second.cycle,
                        Name(now.mode), answer.dump()));
    }
  } else if (!may_be_busy_) {
    Break("to go back is refused: " + answer.dump());
  }
  Do({.verb = ControlVerb::kResume});
}

std::string Bystanders::UseHand() {
  if (!hand_) {
    hand_.emplace("127.0.0.1", robot_.hand()->port, kPatience, nullptr, device_);
    last_ = 0;
  }
  if (dice_.Chance(0.1)) {
    TrySecondHandClient();
    return "a second client of the hand";
  }
  if (dice_.Chance(0.1)) {
    hand_.reset();
    return "the hand's client leaves";
  }
  const HandCommand command = DrawHandCommand();
  const bool is_bad = FindBadValue(command, hand_->State().max_width, device_).has_value();
  const HandTicket ticket = hand_->Start(command);
  if (is_bad) {
    if (AwaitOutcome(ticket, false) != HandResult::kFail) Break("the hand takes a bad command");
    return "a bad command to the hand";
  }
  if (last_ != 0 && !AwaitOutcome(last_, false)) Break("two commands to the hand run at once");
  last_ = ticket;
  may_be_busy_ = true;
  if (dice_.Chance(0.7)) AwaitHand(command, ticket);
  return fmt::format("{}{}", Name(command), may_be_busy_ ? ", left to itself" : "");
}

void Bystanders::TrySecondHandClient() const {
  try {
    const fci::HandClient other("127.0.0.1", robot_.hand()->port, {}, nullptr, device_);
  } catch (const RobotFault&) {
    return;
  }
  Break("a second client of the hand is served");
}

HandCommand Bystanders::DrawHandCommand() {
  if (device_ == HandDevice::kCobotPump) {
    const int timeout_ms = dice_.Chance(0.1) ? -1 : dice_.Whole(100, 3000);
    switch (dice_.Whole(0, 2)) {
      case 0:
        return hand::Vacuum{static_cast<std::uint8_t>(dice_.Chance(0.1) ? 0 : dice_.Whole(1, 255)),
                            static_cast<std::uint8_t>(dice_.Whole(0, 4)), timeout_ms};
      case 1: return hand::DropOff{timeout_ms};
      default: return hand::Stop{};
    }
  }
  const double width = dice_.Chance(0.1) ? dice_.Between(-1, 1) : dice_.Between(0, kHandStroke);
  switch (dice_.Whole(0, 3)) {
    case 0: return hand::Homing{};
    case 1: return hand::Move{width, dice_.Between(0.02, 0.2)};
    case 2:
      return hand::Grasp{width, dice_.Between(0.02, 0.2), dice_.Between(1, 100), 0.005, 0.005};
    default: return hand::Stop{};
  }
}

std::optional<HandResult> Bystanders::AwaitOutcome(HandTicket ticket, bool steps) {
  constexpr int kLongest = 1000;  // times 5 ms, and with steps kStep ms of the robot's time
  for (int i = 0; i < kLongest; ++i) {
    if (const auto result = hand_->Outcome(ticket)) return result;
    if (steps) Do({.verb = ControlVerb::kStep, .cycles = kStep});
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return std::nullopt;
}

void Bystanders::AwaitHand(const HandCommand& command, HandTicket ticket) {
  Do({.verb = ControlVerb::kPause});
  const std::optional<HandResult> result = AwaitOutcome(ticket, true);
  Do({.verb = ControlVerb::kStep, .cycles = kStep});  // a stop ends at once, before any state
  Do({.verb = ControlVerb::kResume});
  if (!result) Break(fmt::format("{} does not end", Name(command)));
  may_be_busy_ = false;
  if (!MayEnd(command, *result)) {
    Break(fmt::format("{} ends as {}", Name(command), Name(*result)));
  }
  if (device_ == HandDevice::kCobotPump) {
    CheckPump(command);
  } else {
    CheckFingers(command);
  }
}

void Bystanders::CheckFingers(const HandCommand& command) {
  const double width = hand_->State().width;
  const auto* const move = std::get_if<hand::Move>(&command);
  const bool is_there = move == nullptr || std::abs(width - move->width) < 1e-3;
  if (!is_there || !(width > -1e-3 && width < kHandStroke + 1e-3)) {
    Break(fmt::format("the hand is {} m wide after {}", width, Name(command)));
  }
}

void Bystanders::CheckPump(const HandCommand& command) {
  const HandState state = hand_->State();
  if (!state.pump || state.is_grasped) Break("the pump holds what is not there");
  const bool found_nothing = std::holds_alternative<hand::Vacuum>(command);
  if (state.pump->device_status != (found_nothing ? PumpStatus::kYellow : PumpStatus::kGreen)) {
    Break(fmt::format("the pump is {} after {}", Name(state.pump->device_status), Name(command)));
  }
}

}  // namespace twin::campaign
