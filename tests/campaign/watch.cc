#include "campaign/watch.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "campaign/lab_rules.h"
#include "conformance/reference_rules.h"
#include "conformance/rig.h"
#include "twin/core/error.h"
#include "twin/core/limits.h"
#include "twin/core/modes.h"
#include "twin/core/time.h"

namespace twin::campaign {

namespace {

constexpr int kMillisecondsToRest = 1000;  ///< after an abort
/// kRestTimeout, and to a stand, after an abort or after it last rested: an arm without its rotors
/// may be too light to be held, and one that has grasped what is fixed, or is wedged by it, may
/// give way.
constexpr int kMillisecondsToBrakes = 1200;
constexpr double kRestSpeed = 0.05;        ///< measured, rad/s
constexpr double kWildShare = 2;           ///< of the velocity limit, that no arm moves at
constexpr double kFinishSpeed = 1e-3;      ///< of the reference, rad/s
constexpr double kFinishAcceleration = 1;  ///< rad/s^2
/// Lost in a row: after more, libfranka's law may accelerate a joint beyond its limit.
constexpr std::uint32_t kLimiterLosses = 2;

constexpr auto kInstability = static_cast<std::size_t>(RobotError::kInstabilityDetected);

/// A planned motion of an arm that nothing takes off its way, that INT knows, and whose chain keeps
/// to its source: the paper's generator and a low-pass filter lag, and a viability filter alone
/// lets a raw stream swing about it (src/reference/VIABILITY.md).
bool MustNotTouch(const scenario::Scenario& world) {
  const scenario::OnboardSection usual;
  const scenario::PlantSection& plant = world.plant;
  return world.motion.plan && world.panel.empty() && world.robot.load == world.onboard.load &&
         world.onboard.K_theta == usual.K_theta && world.onboard.K_x == usual.K_x &&
         plant.mass_scale == 1 && plant.base_tilt == scenario::PlantSection().base_tilt &&
         plant.arm == scenario::PlantSection().arm &&
         world.tick.generator == loop::Generator::kRejoining;
}

bool NeedsBrakes(const scenario::Scenario& world) {
  return !world.plant.armature ||
         std::ranges::any_of(world.objects, [](const auto& object) { return !object.mass; });
}

/// INT's own, between a command of joints and the reference.
bool HasLowPass(const scenario::Scenario& world) {
  return world.onboard.filters.joint_position_hz < 1000 ||
         world.onboard.filters.joint_velocity_hz < 1000;
}

bool IsFinite(const record::TickRecord& tick) {
  const RobotCommand& c = tick.command;
  return twin::IsFinite(tick.q_ext) && twin::IsFinite(tick.dq_ext) && twin::IsFinite(c.q_c) &&
         twin::IsFinite(c.dq_c) && twin::IsFinite(c.O_T_EE_c) && twin::IsFinite(c.O_dP_EE_c) &&
         twin::IsFinite(c.elbow_c) && twin::IsFinite(c.tau_J_d);
}

}  // namespace

/// Passes everything on, and tells the watch of requests.
class WatchedBackend final : public backend::Backend {
 public:
  WatchedBackend(std::unique_ptr<backend::Backend> inner, Watch& watch)
      : inner_(std::move(inner)), watch_(watch) {}
  WatchedBackend(const WatchedBackend&) = delete;
  WatchedBackend& operator=(const WatchedBackend&) = delete;
  ~WatchedBackend() override { watch_.CheckEngine(); }

  [[nodiscard]] backend::Description Describe() const override { return inner_->Describe(); }
  void Configure(const Setting& setting) override {
    Told([&] { inner_->Configure(setting); },
         [&](test::StateChecker& checker, bool accepted) { checker.OnSetting(setting, accepted); });
  }
  void Start(const MotionModes& modes) override {
    Told([&] { inner_->Start(modes); },
         [&](test::StateChecker& checker, bool accepted) { checker.OnStart(modes, accepted); });
  }
  [[nodiscard]] backend::ReadResult Read(backend::ReadRule rule, RobotState& state,
                                         Time& arrival) noexcept override TWIN_REALTIME {
    return inner_->Read(rule, state, arrival);
  }
  void Write(const RobotCommand& command) noexcept override TWIN_REALTIME {
    inner_->Write(command);
  }
  void Stop() override {
    Told([&] { inner_->Stop(); },
         [](test::StateChecker& checker, bool accepted) {
           checker.OnRequest(test::Ask::kStopMove, accepted);
         });
  }
  void Recover() override {
    Told([&] { inner_->Recover(); },
         [](test::StateChecker& checker, bool accepted) {
           checker.OnRequest(test::Ask::kAutomaticErrorRecovery, accepted);
         });
  }

 private:
  template <typename Request, typename Tell>
  void Told(Request request, Tell tell) {
    auto& checker = watch_.specification_;
    try {
      request();
    } catch (const Error&) {
      if (checker) tell(*checker, false);
      throw;
    }
    if (checker) tell(*checker, true);
  }

  std::unique_ptr<backend::Backend> inner_;
  Watch& watch_;
};

std::optional<std::uint64_t> Watch::FirstPush(const scenario::Scenario& world) {
  std::optional<std::uint64_t> first;
  for (const plant::Perturbation& perturbation : world.perturbations) {
    const auto begin = std::visit(
        [](const auto& one) { return one.motion ? Duration::zero() : one.begin; }, perturbation);
    const auto id = static_cast<std::uint64_t>(begin / kCycle);
    first = std::min(first.value_or(id), id);
  }
  return first;
}

backend::Registry Watch::Watched(const backend::Registry& backends) {
  backend::Registry watched;
  watched.Add("mujoco", [this, connect = backends.Find("mujoco")](const backend::Request& request) {
    backend::Connection connection = connect(request);
    robot_ = test::ToCheck(request.robot);
    backend::Backend* const inner = connection.backend.get();
    // Buttons are pressed inside the robot, where their time is known and their outcome is not.
    const bool is_ideal = world_.plant.kind == robot::PlantKind::kIdeal;
    const bool is_torque = world_.motion.interface == control::CommandInterface::kTorque;
    if (world_.panel.empty() &&
        (is_ideal ? world_.robot.load == world_.onboard.load : !is_torque && !world_.application)) {
      specification_.emplace(*robot_, [inner] { return inner->Describe(); });
    }
    if (connection.truth != nullptr && !pushed_from_ && MustNotTouch(world_)) {
      contacts_.emplace(*connection.truth);
    }
    engine_warnings_ = connection.engine_warnings;
    connection.backend = std::make_unique<WatchedBackend>(std::move(connection.backend), *this);
    return connection;
  });
  return watched;
}

void Watch::Note(std::string_view invariant, const test::Finding& finding) {
  if (finding && !finding_) finding_ = Finding{invariant, *finding};
}

void Watch::Put(const record::TickRecord& record) noexcept {
  if (!IsFinite(record)) {
    Note("finite", fmt::format("the tick of state {} is not finite", record.message_id));
  }
  if (record.message_id <= last_tick_ && last_tick_ != 0) {
    Note("ids", fmt::format("the tick of state {} comes after that of state {}", record.message_id,
                            last_tick_));
  }
  last_tick_ = record.message_id;
  if (!world_.application) {
    messages_.OnTick(record);
    source_.OnTick(record);
    CheckLimiter(record);
    CheckFinish(record);
  }
  has_stalled_ = has_stalled_ || record.stalled;
  skipped_ += record.skipped_states;
  ticks_[record.message_id % kKept] = record;
  if (WasWritten(record)) ++written_;
}

void Watch::Put(const record::CycleRecord& record) noexcept {
  const RobotState& state = record.state;
  path_.push_back(state.q);
  Note("finite", test::FindNotFinite(state));
  if (last_ && state.message_id != last_->state.message_id + 1) {
    Note("ids",
         fmt::format("state {} follows state {}", state.message_id, last_->state.message_id));
  }
  CheckCount(record);
  CheckSpecification(record);
  if (last_) CheckReference(last_->state, state, record.violated);
  CheckEnergy(state);
  CheckViability(record);
  CheckGuard(state);
  CheckRest(state);
  CheckPanel(state);
  CheckContact(record);
  const bool moved = last_ && last_->state.robot_mode == RobotMode::kMove;
  if (moved && state.robot_mode != RobotMode::kMove) q_d_at_end_ = state.q_d;
  if (!world_.application) messages_.OnCycle(record);
  last_ = record;
}

void Watch::CheckSpecification(const record::CycleRecord& record) {
  if (!specification_) return;
  if (record.fate == record::CommandFate::kServed && last_) {
    specification_->OnCommand(ticks_[last_->state.message_id % kKept].command);
  }
  specification_->OnState(record.state);
  Note("specification", specification_->finding());
}

void Watch::CheckCount(const record::CycleRecord& record) {
  const std::uint64_t id = record.state.message_id;
  counts_.dropped += record.dropped;
  const std::uint32_t lost_before = last_ ? last_->lost_in_row : 0;
  if (record.fate == record::CommandFate::kHeld) {
    ++counts_.held;
    counts_.longest_loss = std::max<std::uint64_t>(counts_.longest_loss, record.lost_in_row);
    if (record.lost_in_row != lost_before + 1) {
      Note("holds", fmt::format("cycle {}: {} held in a row, after {}", id, record.lost_in_row,
                                lost_before));
    }
    const std::uint32_t most = robot_ ? robot_->limits.abort_after_lost : 20;
    if (record.lost_in_row >= most && record.state.robot_mode == RobotMode::kMove) {
      Note("holds", fmt::format("cycle {}: the motion goes on after {} lost commands", id,
                                record.lost_in_row));
    }
    return;
  }
  if (record.fate != record::CommandFate::kServed) return;
  ++counts_.served;
  if (record.lost_in_row != 0) {
    Note("holds",
         fmt::format("cycle {} is served, and {} are lost in a row", id, record.lost_in_row));
  }
  const record::TickRecord& tick = ticks_[(id - 1) % kKept];
  const bool is_known = tick.message_id == id - 1 && WasWritten(tick);
  if (!is_known) {
    Note("account", fmt::format("cycle {}: a command was served that nobody wrote", id));
  } else if (tick.written > record.at) {
    Note("account", fmt::format("cycle {}: its command was written after it", id));
  }
  finish_served_ = finish_served_ || (is_known && tick.command.motion_generation_finished);
}

void Watch::CheckReference(const RobotState& before, const RobotState& after, bool violated) {
  const bool stops =
      before.robot_mode == RobotMode::kReflex && after.robot_mode == RobotMode::kReflex;
  if (stops && !after.errors.test(kInstability))
    Note("reference", test::FindBadBraking(before, after, robot_->limits.joints, false));
  const bool moves = before.robot_mode == RobotMode::kMove && after.robot_mode == RobotMode::kMove;
  // An external controller moves the arm, and the reference with it; people do when they guide.
  if (!moves || violated || after.controller_mode == ControllerMode::kExternalController) return;
  Note("reference", test::FindBrokenDifferences(before, after));
  Note("reference", test::FindBeyondLimits(before, after, robot_->limits.joints));
}

void Watch::CheckEnergy(const RobotState& state) {
  if (NeedsBrakes(world_) && state.robot_mode != RobotMode::kMove) return;
  for (std::size_t i = 0; i < kJoints && !IsPushed(); ++i) {
    if (std::abs(state.dq[i]) <= kWildShare * robot_->limits.joints.dq_max[i]) continue;
    Note("energy",
         fmt::format("cycle {}: joint {} moves at {} rad/s", state.message_id, i + 1, state.dq[i]));
  }
}

void Watch::CheckViability(const record::CycleRecord& record) {
  const bool is_joint = world_.motion.interface == control::CommandInterface::kJointPosition ||
                        world_.motion.interface == control::CommandInterface::kJointVelocity;
  if (!world_.tick.viability || !is_joint || HasLowPass(world_)) return;
  // The synchronous loop answers late states.
  if (world_.loop == loop::LoopKind::kSynchronous) return;
  if (!record.violated || static_cast<int>(counts_.longest_loss) > *world_.tick.viability) return;
  switch (record.violation.error) {
    case RobotError::kJointMotionGeneratorPositionLimitsViolation:
    case RobotError::kJointMotionGeneratorVelocityLimitsViolation:
    case RobotError::kJointMotionGeneratorVelocityDiscontinuity:
    case RobotError::kJointMotionGeneratorAccelerationDiscontinuity:
      Note("viability",
           fmt::format("cycle {}: {} after {} losses, kept for {}", record.state.message_id,
                       Name(record.violation.error), counts_.longest_loss, *world_.tick.viability));
      break;
    default: break;
  }
}

void Watch::CheckGuard(const RobotState& state) {
  const bool is_joint = world_.motion.interface == control::CommandInterface::kJointPosition ||
                        world_.motion.interface == control::CommandInterface::kJointVelocity;
  if (!is_joint || HasLowPass(world_) || counts_.held > 0) return;
  if (state.robot_mode != RobotMode::kMove) return;
  Note("guard", FindBeyondLab(state, world_.limits, world_.robot.hand != plant::HandKind::kNone));
}

void Watch::CheckRest(const RobotState& state) {
  const bool was_moving = last_ && last_->state.robot_mode == RobotMode::kMove;
  if (was_moving && state.robot_mode == RobotMode::kReflex) {
    since_abort_ = 0;
    has_saturated_ = false;
  }
  if (since_abort_ < 0) return;
  if (state.robot_mode != RobotMode::kReflex) {
    since_abort_ = -1;
    return;
  }
  // What its motors cannot hold, such as a fast load, swings on until the brakes close.
  for (std::size_t i = 0; i < kJoints; ++i) {
    has_saturated_ =
        has_saturated_ || std::abs(state.tau_J_d[i]) > robot_->limits.joints.tau_max[i];
  }
  const bool may_swing = NeedsBrakes(world_) || has_saturated_;
  const int most = may_swing ? kMillisecondsToBrakes : kMillisecondsToRest;
  const auto fastest = std::ranges::max(state.dq, {}, [](double dq) { return std::abs(dq); });
  const bool rests = std::abs(fastest) <= kRestSpeed;
  if (!may_swing && !IsPushed() && state.errors.test(kInstability)) {
    Note("rest", fmt::format("cycle {}: an arm with its rotors' inertia swings", state.message_id));
  }
  // What swings may begin to after it has rested.
  if (may_swing && rests) since_abort_ = 0;
  if (++since_abort_ != most || IsPushed() || rests) return;
  Note("rest", fmt::format("cycle {}: {} ms after an abort a joint moves at {} rad/s",
                           state.message_id, most, fastest));
}

void Watch::CheckLimiter(const record::TickRecord& tick) {
  if (!world_.tick.limiter || !record::WroteCommand(tick) || tick.kept_back != 0) return;
  if (!last_ || last_->state.message_id != tick.message_id) return;
  const RobotState& state = last_->state;
  const JointLimits& limits = robot_->limits.joints;
  const bool is_torque = world_.motion.interface == control::CommandInterface::kTorque;
  if (!is_torque && last_->lost_in_row > kLimiterLosses) return;
  for (std::size_t i = 0; i < kJoints; ++i) {
    double value = 0;
    double limit = limits.ddq_max[i];
    switch (world_.motion.interface) {
      case control::CommandInterface::kJointPosition:
        value = ((tick.command.q_c[i] - state.q_d[i]) / kT - state.dq_d[i]) / kT;
        break;
      case control::CommandInterface::kJointVelocity:
        value = (tick.command.dq_c[i] - state.dq_d[i]) / kT;
        break;
      case control::CommandInterface::kTorque:
        value = (tick.command.tau_J_d[i] - state.tau_J_d[i]) / kT;
        limit = limits.dtau_max[i];
        break;
      case control::CommandInterface::kCartesianPose: return;
    }
    if (std::abs(value) <= limit) continue;
    Note("limiter", fmt::format("the command for state {}: joint {} at {}, and the limit is {}",
                                tick.message_id, i + 1, value, limit));
  }
}

void Watch::CheckFinish(const record::TickRecord& tick) {
  if (tick.action != record::TickAction::kFinished) return;
  const bool must_rest =
      world_.tick.generator == loop::Generator::kRejoining || world_.tick.viability;
  if (!must_rest || !last_ || last_->state.message_id != tick.message_id) return;
  const RobotState& state = last_->state;
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (std::abs(state.dq_d[i]) <= kFinishSpeed &&
        std::abs(state.ddq_d[i]) <= kFinishAcceleration) {
      continue;
    }
    Note("finish", fmt::format("the command for state {} finishes with joint {} at {} rad/s, {} "
                               "rad/s^2",
                               tick.message_id, i + 1, state.dq_d[i], state.ddq_d[i]));
  }
}

void Watch::CheckPanel(const RobotState& state) {
  // Actions are taken before the cycle that follows their state.
  const Duration before = (static_cast<Duration::rep>(state.message_id) - 1) * kCycle;
  bool is_pressed = false;
  for (const robot::PanelEvent& event : world_.panel) {
    if (event.at > before) break;
    if (event.action == PanelAction::kPressUserStop) is_pressed = true;
    if (event.action == PanelAction::kReleaseUserStop) is_pressed = false;
  }
  if (!is_pressed || state.robot_mode == RobotMode::kUserStopped) return;
  Note("panel", fmt::format("cycle {}: the user stop is pressed, and the mode is {}",
                            state.message_id, Name(state.robot_mode)));
}

void Watch::CheckContact(const record::CycleRecord& record) {
  if (!contacts_ || record.state.robot_mode != RobotMode::kMove) return;
  if (counts_.held > 0 || has_stalled_) return;
  contacts_->Look(record.at);
  if (contacts_->cycles() == 0) return;
  const plant::ContactPair pair = contacts_->Pairs().front();
  Note("contact", fmt::format("cycle {}: {} touches {} in a planned motion",
                              record.state.message_id, pair.a, pair.b));
}

}  // namespace twin::campaign
