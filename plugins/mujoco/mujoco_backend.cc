#include "plugins/mujoco/mujoco_backend.h"

#include <memory>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "twin/core/error.h"
#include "twin/plant/ideal_plant.h"
#include "twin/plant/mujoco_plant.h"
#include "twin/robot/robot.h"

namespace twin::plugins {
namespace {

using onboard::MoveStatus;
using onboard::RecoveryStatus;
using onboard::SetterStatus;

backend::MotionEnd EndOf(MoveStatus status) noexcept {
  switch (status) {
    case MoveStatus::kMotionStarted: return backend::MotionEnd::kNone;
    case MoveStatus::kSuccess: return backend::MotionEnd::kSuccess;
    case MoveStatus::kPreempted: return backend::MotionEnd::kPreempted;
    default: return backend::MotionEnd::kAborted;
  }
}

/// The emulated robot behind the backend seam.
class MujocoBackend final : public backend::Backend {
 public:
  MujocoBackend(const backend::Request& request, std::unique_ptr<plant::Plant> plant,
                std::string plant_name)
      : robot_(request.robot, std::move(plant), request.events, request.state_ready, request.sink),
        events_(request.events),
        plant_name_(std::move(plant_name)) {}

  backend::Description Describe() const override {
    backend::Description description;
    description.name = "mujoco";
    description.robot = fmt::format("emulated Panda, {}", plant_name_);
    description.last_end = EndOf(robot_.last_end());
    for (const Violation& violation : robot_.last_violations().items()) {
      description.last_errors.set(static_cast<std::size_t>(violation.error));
      description.violations.push_back(violation);
    }
    return description;
  }

  void Configure(const backend::Setting& setting) override {
    const auto& impedance = std::get<backend::JointImpedance>(setting);
    switch (robot_.SetJointImpedance(impedance.K_theta)) {
      case SetterStatus::kSuccess: return;
      case SetterStatus::kCommandNotPossibleRejected: throw Refused("Set Joint Impedance");
      case SetterStatus::kInvalidArgumentRejected:
        throw InputError(fmt::format(
            "Set Joint Impedance rejected: K_theta is [{}] Nm/rad; each must lie in [0, {}]",
            fmt::join(impedance.K_theta, ", "), onboard::kMaxJointStiffness));
    }
  }

  void Start(const MotionModes& modes) override {
    switch (robot_.Move(modes)) {
      case MoveStatus::kMotionStarted: return;
      case MoveStatus::kInvalidArgumentRejected:
        throw RobotFault(
            fmt::format("Move rejected: this robot offers no {} motion with the {} controller; use "
                        "joint_position or joint_velocity with joint_impedance",
                        Name(modes.generator), Name(modes.controller)));
      default: throw Refused("Move");
    }
  }

  backend::ReadResult Read(backend::ReadRule rule, RobotState& state,
                           Time& arrival) noexcept override {
    robot::StateLink& states = robot_.states();
    if (!states.has_new()) return backend::ReadResult::kPending;
    arrival = states.arrival();
    const RobotState& newest = states.Take();
    const bool stale = rule == backend::ReadRule::kFresh && arrival != events_.Now();
    if (stale) return backend::ReadResult::kPending;
    state = newest;
    return backend::ReadResult::kState;
  }

  void Write(const RobotCommand& command) noexcept override { robot_.Send(command); }

  void Stop() override { robot_.StopMove(); }

  void Recover() override {
    if (robot_.AutomaticErrorRecovery() != RecoveryStatus::kSuccess) {
      throw Refused("Automatic Error Recovery");
    }
  }

 private:
  RobotFault Refused(std::string_view request) const {
    return RobotFault(fmt::format(
        "{} rejected: not possible in the current mode (\"{}\"), or the arm still moves", request,
        Name(robot_.mode())));
  }

  robot::Robot robot_;
  rt::EventQueue& events_;
  std::string plant_name_;
};

backend::Connection Connect(const backend::Request& request) {
  backend::Connection connection;
  if (request.robot.plant_kind == robot::PlantKind::kIdeal) {
    connection.backend = std::make_unique<MujocoBackend>(
        request, std::make_unique<plant::IdealPlant>(), "ideal plant (q = q_d)");
    return connection;
  }
  auto plant = plant::MujocoPlant::Create(request.robot.plant);
  connection.truth = plant.get();
  connection.engine_warnings = [source = plant.get()] { return source->DescribeWarnings(); };
  connection.uses_meshes = plant->uses_meshes();
  connection.backend = std::make_unique<MujocoBackend>(request, std::move(plant), "MuJoCo plant");
  return connection;
}

}  // namespace

void RegisterMujoco(backend::Registry& registry) {
  registry.Add("mujoco", &Connect);
}

}  // namespace twin::plugins
