#include "twin/run/stepped_robot.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "run/resolve.h"
#include "run/stepped_chain.h"
#include "twin/core/error.h"
#include "twin/model/arm_model.h"
#include "twin/model/transform.h"
#include "twin/plant/observers.h"
#include "twin/robot/robot.h"
#include "twin/run/robot_config.h"

namespace twin::run {
namespace {

constexpr std::uint64_t kSettleCycles = 100;
/// Cycles within which a motion must begin or end.
constexpr std::uint64_t kTimeoutCycles = 2000;

/// Shares of the Cartesian limits of velocity, acceleration and jerk within which poses are led.
/// Joint 2 may accelerate with 7.5 rad/s^2 and has the end effector 0.4 to 0.8 m away: 3 m/s^2 of
/// 13, and 1000 m/s^3 of 6500. A decision.
struct PoseShare {
  double velocity = 0.6;
  double acceleration = 0.23;
  double jerk = 0.15;
};
constexpr PoseShare kPoseShare;

loop::TickConfig SteppedTick(const scenario::Scenario& scenario, const scenario::RobotData& robot) {
  loop::TickConfig tick = MakeTick(scenario, robot);
  for (CartesianBound* const limits : {&tick.cartesian.translation, &tick.cartesian.rotation}) {
    limits->dp_max *= kPoseShare.velocity;
    limits->ddp_max *= kPoseShare.acceleration;
    limits->dddp_max *= kPoseShare.jerk;
  }
  return tick;
}

scenario::Scenario Stepped(scenario::Scenario scenario) {
  if (scenario.base) {
    throw InputError("base: a stepped robot stands on the world; leave the base out");
  }
  if (scenario.motion.interface == control::CommandInterface::kTorque) {
    const scenario::Delay cost = scenario.tick.cost;
    scenario.tick = scenario::TorqueTick();
    scenario.tick.cost = cost;
  }
  return scenario;
}

std::array<double, 4> Quaternion(const Transform& X) {
  const Eigen::Quaterniond turn = model::Orientation(X);
  const double sign = turn.w() < 0 ? -1 : 1;
  return {sign * turn.w(), sign * turn.x(), sign * turn.y(), sign * turn.z()};
}

Vector3 Translation(const Transform& X) {
  return {X[12], X[13], X[14]};
}

}  // namespace

std::vector<StepReport::Field> StepReport::Fields() {
  std::vector<Field> fields;
  std::size_t begin = 0;
  for (const auto& [name, size] : std::initializer_list<std::pair<std::string_view, std::size_t>>{
           {"q", 7},         {"dq", 7},       {"q_d", 7},    {"dq_d", 7},       {"tau_J", 7},
           {"tau_ext", 7},   {"position", 3}, {"turn", 4},   {"twist", 6},      {"position_d", 3},
           {"turn_d", 4},    {"wrench", 6},   {"width", 1},  {"is_grasped", 1}, {"success_rate", 1},
           {"contact", 6},   {"cycles", 1},   {"served", 1}, {"held", 1},       {"margin", 1},
           {"kept_back", 1}, {"time", 1},     {"errors", 1}, {"is_moving", 1}}) {
    fields.push_back({name, begin, size});
    begin += size;
  }
  TWIN_CHECK(begin == kSize);
  return fields;
}

/// Robot, queue and chain; the counts of a step come from the records of the robot's cycles.
class SteppedRobot::Impl final : private record::RecordSink {
 public:
  Impl(const scenario::Scenario& scenario, const RunFiles& files)
      : data_(scenario::LoadRobotData(files.models, scenario.robot.model, scenario.robot.hand)),
        config_(MakeRobotConfig(scenario, data_, files)),
        modes_(ModesOf(scenario.motion)),
        made_(robot::MakePlant(config_)),
        engine_(made_.engine),
        robot_(config_, std::move(made_.plant), events_, states_, this),
        chain_(events_, robot_, scenario.motion.interface, SteppedTick(scenario, data_),
               MakeControllerLoop(scenario.controller)),
        between_deposits_(std::max<std::uint64_t>(
            1, static_cast<std::uint64_t>(std::lround(1000 / scenario.controller.rate_hz)))) {
    if (engine_ != nullptr) {
      contacts_.emplace(*engine_);
      std::vector<double> qpos(engine_->qpos_size());
      engine_->CopyQpos(qpos);
      for (const auto& [name, pose] : plant::FreeBodies(engine_->model(), qpos)) {
        names_.push_back(name);
        objects_.emplace_back(*engine_, name);
      }
    }
    robot_.Begin();
    Pass(kSettleCycles);
    Keep();
  }

  void Reset(const EpisodeStart& start);
  void KeepAsStart();
  void Advance(std::uint64_t cycles) {
    served_ = held_ = 0;
    chain_.BeginStep();
    for (std::uint64_t done = 0; done < cycles;) {
      const std::uint64_t next = std::min(done + between_deposits_, cycles);
      chain_.Deposit(robot_.next_cycle(), static_cast<double>(next) / static_cast<double>(cycles));
      Pass(next - done);
      done = next;
    }
    chain_.EndStep();
    Report(cycles);
  }
  bool StartHand(const HandCommand& command) {
    if (!robot_.has_hand()) throw InputError("hand: the scenario's robot has none (robot.hand)");
    return robot_.StartHand(command).ticket != 0;
  }

  [[nodiscard]] SteppedChain& chain() noexcept { return chain_; }
  [[nodiscard]] const StepReport& report() const noexcept { return report_; }
  [[nodiscard]] const std::vector<std::string>& names() const noexcept { return names_; }
  [[nodiscard]] const plant::TruthProbe* truth() const noexcept { return engine_; }
  void CopyObjects(std::span<double> out) const noexcept;
  [[nodiscard]] std::string DescribeErrors() const;

 private:
  /// A state has arrived at the workstation.
  struct States final : rt::EventHandler {
    explicit States(Impl& impl) noexcept : impl_(impl) {}
    void OnEvent(Time now, std::uint64_t /*message_id*/) noexcept override {
      impl_.chain_.OnState(now);
    }
    Impl& impl_;
  };
  struct Start {
    rt::EventQueue events;
    robot::Robot::Snapshot robot;
  };

  void Put(const record::CycleRecord& record) noexcept override {
    ++cycles_;
    served_ += record.fate == record::CommandFate::kServed ? 1 : 0;
    held_ += record.fate == record::CommandFate::kHeld ? 1 : 0;
  }
  void Put(const record::TickRecord& /*record*/) noexcept override {}

  /// Runs cycles, and what belongs to the last one before the next.
  void Pass(std::uint64_t cycles) noexcept {
    const std::uint64_t end = cycles_ + cycles;
    while (cycles_ < end || *events_.NextTime() < robot_.next_cycle()) events_.RunNext();
  }
  void Keep() { start_.emplace(Start{events_, robot_.Save()}); }
  void Vary(const EpisodeStart& start);
  void BeginMotion(std::uint64_t seed);
  void Report(std::uint64_t cycles) noexcept;

  const scenario::RobotData data_;
  const robot::RobotConfig config_;
  const MotionModes modes_;
  rt::EventQueue events_;
  States states_{*this};
  robot::MadePlant made_;
  plant::MujocoPlant* engine_;
  robot::Robot robot_;
  SteppedChain chain_;
  const std::uint64_t between_deposits_;  ///< cycles
  std::optional<plant::ContactWrench> contacts_;
  std::vector<std::string> names_;
  std::vector<plant::BodyView> objects_;
  std::optional<Start> start_;
  std::uint64_t cycles_ = 0;
  std::uint64_t begun_ = 0;  ///< cycles_ at the motion's first command
  std::uint64_t served_ = 0;
  std::uint64_t held_ = 0;
  StepReport report_;
};

void SteppedRobot::Impl::Reset(const EpisodeStart& start) {
  chain_.Stop();
  events_ = start_->events;
  robot_.Restore(start_->robot);
  if (start.q) robot_.Reset(*start.q);
  Vary(start);
  BeginMotion(start.seed);
}

void SteppedRobot::Impl::Vary(const EpisodeStart& start) {
  robot::LinkConfig link = config_.link;
  for (faults::DirectionConfig* const direction : {&link.state, &link.command}) {
    if (start.delay) direction->delay = faults::DelayModel(faults::ConstantDelay{*start.delay});
    if (start.loss) direction->loss = faults::LossModel(faults::IndependentLoss{*start.loss});
  }
  robot_.Renew(link, start.seed);
  if (engine_ == nullptr) {
    if (start.places.empty() && start.masses.empty() && start.frictions.empty()) return;
    throw InputError("reset: the ideal plant has no bodies; say plant.kind: mujoco");
  }
  const mjModel_& model = engine_->model();
  for (const auto& [name, mass] : start.masses) {
    engine_->SetMass(plant::BodyNamed(model, name), mass);
  }
  for (const auto& [name, friction] : start.frictions) {
    engine_->SetFriction(plant::BodyNamed(model, name), friction);
  }
  for (const auto& [name, X_WB] : start.places) {
    const auto overlap = robot_.Place(plant::FreeBodyNamed(model, name), X_WB);
    if (!overlap) continue;
    throw InputError(
        fmt::format("reset: {} at ({:.3f}, {:.3f}, {:.3f}) m would be {:.1f} mm inside "
                    "of {}; place it elsewhere",
                    name, X_WB[12], X_WB[13], X_WB[14], overlap->depth * 1e3,
                    plant::PartOfShape(model, overlap->geom)));
  }
}

void SteppedRobot::Impl::BeginMotion(std::uint64_t seed) {
  chain_.Start(modes_, seed);
  const MoveStatus status = robot_.Move(modes_);
  if (status != MoveStatus::kMotionStarted) {
    throw RobotFault(fmt::format("reset: the robot refuses the motion (Move status {})",
                                 static_cast<int>(status)));
  }
  served_ = held_ = 0;
  for (std::uint64_t waited = 0; served_ == 0; ++waited) {
    if (waited == kTimeoutCycles || robot_.mode() == RobotMode::kReflex) {
      throw RobotFault(
          "reset: no motion begins, as its first commands are lost or refused; choose smaller "
          "delays and losses");
    }
    Pass(1);
  }
  chain_.BeginStep();
  begun_ = cycles_;
  served_ = held_ = 0;
  Report(0);
}

void SteppedRobot::Impl::KeepAsStart() {
  chain_.Stop();
  if (robot_.mode() == RobotMode::kMove) robot_.StopMove();
  for (std::uint64_t waited = 0; robot_.mode() != RobotMode::kIdle || !robot_.AtRest(); ++waited) {
    if (waited == kTimeoutCycles) {
      throw RobotFault("keep: the arm does not come to rest. " + DescribeErrors());
    }
    Pass(1);
  }
  Keep();
}

void SteppedRobot::Impl::Report(std::uint64_t cycles) noexcept {
  const RobotState& state = chain_.state();
  StepReport& report = report_;
  report.q = state.q;
  report.dq = state.dq;
  report.q_d = state.q_d;
  report.dq_d = state.dq_d;
  report.tau_J = state.tau_J;
  report.tau_ext = state.tau_ext_hat_filtered;
  report.position = Translation(state.O_T_EE);
  report.turn = Quaternion(state.O_T_EE);
  report.twist =
      model::ArmModel::Panda().Twist(model::Frame::kEndEffector, state.q, state.dq, state.F_T_EE);
  report.position_d = Translation(state.O_T_EE_d);
  report.turn_d = Quaternion(state.O_T_EE_d);
  report.wrench = state.O_F_ext_hat_K;
  report.success_rate = state.control_command_success_rate;
  if (robot_.has_hand()) {
    const HandState hand = robot_.hand_state();
    report.width = hand.width;
    report.is_grasped = hand.is_grasped ? 1 : 0;
  }
  if (contacts_) report.contact = contacts_->About(Translation(robot_.state().O_T_EE));
  report.cycles = static_cast<double>(cycles);
  report.served = static_cast<double>(served_);
  report.held = static_cast<double>(held_);
  report.margin = chain_.margin().value_or(std::numeric_limits<double>::quiet_NaN());
  report.kept_back = static_cast<double>(chain_.kept_back());
  report.time = static_cast<double>(cycles_ - begun_) * kCycleSeconds;
  report.is_moving = robot_.mode() == RobotMode::kMove ? 1 : 0;
  RobotErrors errors;
  const robot::LastMotion motion = robot_.last_motion();
  for (const Violation& violation : motion.violations.items()) {
    errors.set(static_cast<std::size_t>(violation.error));
  }
  report.errors = static_cast<double>(errors.to_ullong());
}

void SteppedRobot::Impl::CopyObjects(std::span<double> out) const noexcept {
  auto at = out.begin();
  for (const plant::BodyView& object : objects_) {
    const Transform X_WB = object.Pose();
    at = std::ranges::copy(Translation(X_WB), at).out;
    at = std::ranges::copy(Quaternion(X_WB), at).out;
    at = std::ranges::copy(object.Twist(), at).out;
  }
}

std::string SteppedRobot::Impl::DescribeErrors() const {
  std::string text;
  const robot::LastMotion motion = robot_.last_motion();
  for (const Violation& violation : motion.violations.items()) {
    if (!text.empty()) text += ' ';
    text += Describe(violation);
  }
  return text;
}

SteppedRobot::SteppedRobot(const scenario::Scenario& scenario, const RunFiles& files)
    : impl_(std::make_unique<Impl>(Stepped(scenario), files)) {}
SteppedRobot::~SteppedRobot() = default;

void SteppedRobot::Reset(const EpisodeStart& start) {
  impl_->Reset(start);
}
void SteppedRobot::SetTarget(const reference::Target& target) {
  impl_->chain().SetTarget(target);
}
bool SteppedRobot::StartHand(const HandCommand& command) {
  return impl_->StartHand(command);
}
void SteppedRobot::Advance(std::uint64_t cycles) {
  impl_->Advance(cycles);
}
void SteppedRobot::KeepAsStart() {
  impl_->KeepAsStart();
}
const StepReport& SteppedRobot::report() const noexcept {
  return impl_->report();
}
const std::vector<std::string>& SteppedRobot::objects() const noexcept {
  return impl_->names();
}
void SteppedRobot::CopyObjects(std::span<double> out) const noexcept {
  impl_->CopyObjects(out);
}
std::string SteppedRobot::DescribeErrors() const {
  return impl_->DescribeErrors();
}
const plant::TruthProbe* SteppedRobot::truth() const noexcept {
  return impl_->truth();
}

}  // namespace twin::run
