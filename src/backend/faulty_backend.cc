#include "twin/backend/faulty_backend.h"

#include <algorithm>
#include <limits>
#include <string_view>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::backend {
namespace {

bool Lists(const FaultSchedule& schedule, std::uint64_t message) noexcept {
  return std::binary_search(schedule.messages.begin(), schedule.messages.end(), message);
}

bool CanStrike(const FaultSchedule& schedule) {
  return schedule.probability > 0 || !schedule.messages.empty();
}

bool Strikes(const FaultSchedule& schedule, const Random& random, std::uint64_t message) noexcept {
  const bool drawn = schedule.probability > 0 && random.Uniform(message) < schedule.probability;
  return drawn || Lists(schedule, message);
}

void ValidateSchedule(std::string_view field, const FaultSchedule& schedule) {
  RequireInRange(fmt::format("faults.{}.probability", field), schedule.probability, 0, 1);
  const auto& messages = schedule.messages;
  for (std::size_t i = 1; i < messages.size(); ++i) {
    if (messages[i] > messages[i - 1]) continue;
    throw InputError(fmt::format(
        "faults.{}.messages[{}] is {}; it must be above {}, the one before it: list them in rising "
        "order, each once",
        field, i, messages[i], messages[i - 1]));
  }
}

/// Refuses a schedule that can never strike because command_loss loses its messages.
void RequireNotAlwaysLost(std::string_view field, const FaultSchedule& schedule,
                          const faults::LossModel& loss) {
  const auto* independent = std::get_if<faults::IndependentLoss>(&loss.parameters());
  const auto* chain = std::get_if<faults::GilbertElliottLoss>(&loss.parameters());
  const bool all = (independent != nullptr && independent->probability == 1) ||
                   (chain != nullptr && chain->loss_good == 1 && chain->loss_bad == 1);
  if (all && CanStrike(schedule)) {
    throw InputError(fmt::format(
        "faults.{} can never strike: faults.command_loss loses every command; remove one of them",
        field));
  }
  if (!std::holds_alternative<faults::ScriptedLoss>(loss.parameters())) return;
  faults::LossProcess process(loss, 0, RandomStream::kFault, RandomStream::kFault);
  for (const std::uint64_t message : schedule.messages) {
    if (!process.Loses(message)) continue;
    throw InputError(fmt::format(
        "faults.{}.messages has {}, which faults.command_loss loses; remove it from one "
        "of them",
        field, message));
  }
}

/// Refuses schedules that can never strike because a swap already takes the message or the next
/// one.
void RequireNoConflictWithSwaps(const FaultSchedule& swapped, const FaultSchedule& delayed) {
  for (const std::uint64_t message : swapped.messages) {
    if (Lists(swapped, message + 1)) {
      throw InputError(fmt::format(
          "faults.command_swapped.messages has {} and {}; the second is already swapped "
          "with the first: remove it",
          message, message + 1));
    }
    for (const std::uint64_t other : {message, message + 1}) {
      if (!Lists(delayed, other)) continue;
      throw InputError(
          fmt::format("faults.command_delayed.messages has {}, which faults.command_swapped swaps; "
                      "remove it from one of them",
                      other));
    }
  }
  if (swapped.probability == 1 && CanStrike(delayed)) {
    throw InputError(
        "faults.command_delayed can never strike: faults.command_swapped.probability is 1; remove "
        "one of them");
  }
}

/// Writes NaN to the fields that a motion with these modes uses. @returns false if it uses none.
bool Spoil(RobotCommand& command, MotionGeneratorMode generator,
           ControllerMode controller) noexcept {
  const auto spoil = [](auto& field) noexcept {
    field.fill(std::numeric_limits<double>::quiet_NaN());
  };
  switch (generator) {
    case MotionGeneratorMode::kIdle:
    case MotionGeneratorMode::kNone: break;
    case MotionGeneratorMode::kJointPosition: spoil(command.q_c); break;
    case MotionGeneratorMode::kJointVelocity: spoil(command.dq_c); break;
    case MotionGeneratorMode::kCartesianPosition: spoil(command.O_T_EE_c); break;
    case MotionGeneratorMode::kCartesianVelocity: spoil(command.O_dP_EE_c); break;
  }
  const bool cartesian = generator == MotionGeneratorMode::kCartesianPosition ||
                         generator == MotionGeneratorMode::kCartesianVelocity;
  if (cartesian && command.valid_elbow) spoil(command.elbow_c);
  const bool torque = controller == ControllerMode::kExternalController;
  if (torque) spoil(command.tau_J_d);
  return torque || generator != MotionGeneratorMode::kIdle;
}

/// Derives the plan's own seed, so that its streams differ from the link's.
std::uint64_t SeedOf(const FaultPlan& plan) {
  plan.Validate();
  const auto bits = Random(plan.seed, RandomStream::kFault).Bits(0);
  return (std::uint64_t{bits[0]} << 32) | bits[1];
}

}  // namespace

void FaultPlan::Validate() const {
  const std::pair<std::string_view, const FaultSchedule&> schedules[] = {
      {"command_duplicated", command_duplicated},
      {"command_swapped", command_swapped},
      {"command_delayed", command_delayed},
      {"command_garbage", command_garbage}};
  for (const auto& [field, schedule] : schedules) {
    ValidateSchedule(field, schedule);
    RequireNotAlwaysLost(field, schedule, command_loss);
  }
  RequireNoConflictWithSwaps(command_swapped, command_delayed);
}

FaultyBackend::FaultyBackend(std::unique_ptr<Backend> inner, FaultPlan plan)
    : inner_(std::move(inner)),
      plan_(std::move(plan)),
      seed_(SeedOf(plan_)),
      state_loss_(plan_.state_loss, seed_, RandomStream::kStateLoss, RandomStream::kStateBurst),
      command_loss_(plan_.command_loss, seed_, RandomStream::kCommandLoss,
                    RandomStream::kCommandBurst) {
  TWIN_CHECK(inner_ != nullptr);
}

Description FaultyBackend::Describe() const {
  Description description = inner_->Describe();
  description.robot += fmt::format(", with injected faults (seed {})", plan_.seed);
  return description;
}

void FaultyBackend::Configure(const Setting& setting) {
  RequireConnection("Configure");
  inner_->Configure(setting);
}

void FaultyBackend::Start(const MotionModes& modes) {
  RequireConnection("Start");
  inner_->Start(modes);
}

ReadResult FaultyBackend::Read(ReadRule rule, RobotState& state, Time& arrival) noexcept {
  if (gone()) return ReadResult::kLost;
  Time read_arrival{};
  const ReadResult result = inner_->Read(rule, read_, read_arrival);
  if (result != ReadResult::kState) return result;
  if (plan_.gone_from && read_.message_id >= *plan_.gone_from) {
    gone_.store(true, std::memory_order_relaxed);  // a flag; publishes no other data
    return ReadResult::kLost;
  }
  if (state_loss_.Loses(read_.message_id)) {
    ++counts_.states_lost;
    return ReadResult::kPending;
  }
  generator_ = read_.motion_generator_mode;
  controller_ = read_.controller_mode;
  state = read_;
  arrival = read_arrival;
  return ReadResult::kState;
}

void FaultyBackend::Write(const RobotCommand& command) noexcept {
  if (gone()) return;
  const Outgoing late = held_;
  const bool overtaken = late.copies > 0 && held_is_swapped_;
  held_.copies = 0;
  if (!overtaken) PutOut(late);
  const Outgoing outgoing = Prepare(command);
  if (overtaken || !Hold(outgoing)) PutOut(outgoing);
  if (overtaken) PutOut(late);
}

void FaultyBackend::Stop() {
  if (!gone()) inner_->Stop();
}

void FaultyBackend::Recover() {
  RequireConnection("Recover");
  inner_->Recover();
}

bool FaultyBackend::gone() const noexcept {
  return gone_.load(std::memory_order_relaxed);
}

void FaultyBackend::RequireConnection(const char* request) const {
  if (!gone()) return;
  throw RobotFault(fmt::format("{} rejected: the connection to the robot is gone", request));
}

/// Applies loss, garbage and duplication to the command.
FaultyBackend::Outgoing FaultyBackend::Prepare(const RobotCommand& command) noexcept {
  const std::uint64_t id = command.message_id;
  Outgoing outgoing{.command = command, .copies = 0};
  if (command_loss_.Loses(id)) {
    ++counts_.commands_lost;
    return outgoing;
  }
  outgoing.copies = 1;
  if (Strikes(plan_.command_garbage, Random(seed_, RandomStream::kFault), id)) {
    counts_.commands_garbage += Spoil(outgoing.command, generator_, controller_) ? 1 : 0;
  }
  if (Strikes(plan_.command_duplicated, Random(seed_, RandomStream::kCommandDuplicate), id)) {
    ++counts_.commands_duplicated;
    outgoing.copies = 2;
  }
  return outgoing;
}

/// @returns true if the command is now held until the next one.
bool FaultyBackend::Hold(const Outgoing& outgoing) noexcept {
  if (outgoing.copies == 0) return false;
  const std::uint64_t id = outgoing.command.message_id;
  held_is_swapped_ =
      Strikes(plan_.command_swapped, Random(seed_, RandomStream::kCommandReorder), id);
  const bool delayed = !held_is_swapped_ && Strikes(plan_.command_delayed,
                                                    Random(seed_, RandomStream::kCommandDelay), id);
  if (!held_is_swapped_ && !delayed) return false;
  ++(delayed ? counts_.commands_delayed : counts_.commands_swapped);
  held_ = outgoing;
  return true;
}

void FaultyBackend::PutOut(const Outgoing& outgoing) noexcept {
  for (int copy = 0; copy < outgoing.copies; ++copy) inner_->Write(outgoing.command);
}

}  // namespace twin::backend
