#include "run/prepared_motion.h"

#include <optional>
#include <utility>

#include <fmt/format.h>

#include "twin/control/controller_library.h"
#include "twin/control/parameters.h"
#include "twin/core/error.h"
#include "twin/core/joint_vector.h"
#include "twin/model/arm_model.h"
#include "twin/model/inverse_kinematics.h"
#include "twin/scenario/names.h"
#include "twin/scenario/scenario.h"

namespace twin::run {
namespace {

/// What a run may take beyond the planned motion: settling behind the reference generator (time
/// constant 1 s at lambda = 1e-3, so 10 s are 5e-5 of what was left) and connecting.
constexpr Duration kBeyondPlan = std::chrono::seconds(20);

/// @returns the motion's controller with its parameters. It refers to the motion.
std::unique_ptr<control::Controller> MakeController(const scenario::Scenario& scenario,
                                                    const scenario::RobotData& robot,
                                                    const Motion& motion, const Transform& F_T_EE,
                                                    const control::ControllerRegistry& known) {
  const scenario::ControllerSection& section = motion.controller;
  const control::ControllerRequest request{
      .trajectory = motion.trajectory,
      .interface = motion.interface,
      .poses = motion.poses ? &*motion.poses : nullptr,
      .live = motion.live,
      .limits = robot.limits,
      .cartesian = robot.cartesian,
      .F_T_EE = F_T_EE,
      .friction_compensated = scenario.onboard.friction_compensation};
  const bool is_loaded = !section.library.empty();
  auto controller = scenario::At(is_loaded ? scenario.places.library : scenario.places.controller,
                                 is_loaded ? section.library.string() : section.type, [&] {
                                   return is_loaded ? control::LoadController(section.library,
                                                                              section.type, request)
                                                    : known.Find(section.type)(request);
                                 });
  if (controller->command_interface() != request.interface) {
    throw InputError(fmt::format(
        "controller {} commands {}, and motion.interface is {}; let them agree", section.type,
        scenario::NameOf(scenario::kInterfaceNames, controller->command_interface()),
        scenario::NameOf(scenario::kInterfaceNames, request.interface)));
  }
  control::ParameterReader parameters(section.parameters);
  controller->Configure(parameters);
  parameters.RefuseUnread();
  return controller;
}

loop::TickConfig OfSource(loop::TickConfig tick, const std::optional<double>& source_rate_hz) {
  if (source_rate_hz) tick.source_rate_hz = *source_rate_hz;
  return tick;
}

}  // namespace

PreparedMotion::PreparedMotion(const scenario::Scenario& scenario, const scenario::RobotData& robot,
                               Motion motion, const control::ControllerRegistry& known)
    : motion_(std::move(motion)),
      F_T_EE_(robot.F_T_EE(scenario.onboard.NE_T_EE)),
      modes_(ModesOf(scenario.motion)),
      tick_(OfSource(MakeTick(scenario, robot), motion_.source_rate_hz)),
      controller_loop_(MakeControllerLoop(scenario.controller)),
      controller_(MakeController(scenario, robot, motion_, F_T_EE_, known)) {
  RequireVelocitiesByPosition(robot.limits, motion_);
  RequireEndEffectorWithinLimits(robot.cartesian, F_T_EE_, motion_);
  RequireWithinLimits(scenario, robot, motion_);
}

loop::MotionRun PreparedMotion::Run(backend::Backend& backend, std::uint64_t seed) {
  return {.backend = backend,
          .controller = *controller_,
          .modes = modes_,
          .kind = motion_.loop,
          .tick = tick_,
          .controller_loop = controller_loop_,
          .seed = seed,
          .time_limit = motion_.trajectory.duration() + kBeyondPlan,
          .sink = nullptr,
          .progress = {},
          .event = {},
          .interrupted = nullptr};
}

std::optional<PoseError> PreparedMotion::PoseErrorAt(const JointVector& q) const {
  if (motion_.live != nullptr) return std::nullopt;
  if (motion_.interface != control::CommandInterface::kCartesianPose && !motion_.poses &&
      !controller_->follows_pose()) {
    return std::nullopt;
  }
  const auto pose = [this](const JointVector& at) {
    return model::ArmModel::Panda().Pose(model::Frame::kEndEffector, at, F_T_EE_);
  };
  const Transform goal = motion_.poses ? motion_.poses->goal() : pose(motion_.trajectory.goal());
  const Vector6 way = model::Displacement(pose(q), goal);
  return PoseError{.distance = HalfNorm(way, 0), .angle = HalfNorm(way, 3)};
}

scenario::Scenario As(const scenario::Scenario& scenario, const Motion& motion) {
  scenario::Scenario as = scenario;
  as.loop = motion.loop;
  as.tick = motion.tick;
  as.controller = motion.controller;
  as.motion = scenario::MotionSection();
  as.motion.interface = motion.interface;
  as.motion.controller = motion.impedance;
  as.motion.waypoints = {{.q = motion.trajectory.start()}, {.q = motion.trajectory.goal()}};
  as.Validate();
  return as;
}

}  // namespace twin::run
