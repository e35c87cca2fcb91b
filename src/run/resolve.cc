#include "run/resolve.h"

#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/time.h"
#include "twin/fci/protocol.h"
#include "twin/model/arm_model.h"
#include "twin/model/transform.h"
#include "twin/reference/rate_limiter.h"
#include "twin/scenario/link_section.h"
#include "twin/scenario/scenario.h"

namespace twin::run {
namespace {

/// States of protocol 10 are in single precision. A client that continues from them is off by half
/// the distance of two such numbers: up to 2.4e-7 rad of a joint, 6e-8 of a pose. INT takes that
/// for motion, and allows it. Not public: a decision.
void AllowRounding(onboard::OnboardConfig& config) {
  constexpr double kJoint = 2.4e-7;
  constexpr double kPose = 6e-8;
  const auto allow = [](double rounding, double& dp, double& ddp, double& dddp) {
    dp += rounding / kCycleSeconds;
    ddp += rounding / (kCycleSeconds * kCycleSeconds);
    dddp += rounding / (kCycleSeconds * kCycleSeconds * kCycleSeconds);
  };
  config.own_limits = config.limits;
  JointLimits& joints = config.limits;
  for (std::size_t i = 0; i < kJoints; ++i) {
    allow(kJoint, joints.dq_max[i], joints.ddq_max[i], joints.dddq_max[i]);
  }
  CartesianLimits& cartesian = config.cartesian;
  allow(kPose, cartesian.translation.dp_max, cartesian.translation.ddp_max,
        cartesian.translation.dddp_max);
  allow(kPose, cartesian.rotation.dp_max, cartesian.rotation.ddp_max, cartesian.rotation.dddp_max);
  allow(kJoint, cartesian.elbow.dp_max, cartesian.elbow.ddp_max, cartesian.elbow.dddp_max);
}

onboard::OnboardConfig MakeOnboard(const scenario::Scenario& scenario,
                                   const scenario::RobotData& robot) {
  onboard::OnboardConfig config;
  const scenario::OnboardSection& section = scenario.onboard;
  config.limits = robot.limits;
  config.cartesian = robot.cartesian;
  config.arm = robot.arm;
  if (robot.protocol == fci::VersionOf(fci::Protocol::k10)) {
    if (section.filters != setting::Filters()) {
      throw InputError(fmt::format(
          "onboard.filters: {} has none that a client could set; leave them out", robot.name));
    }
    AllowRounding(config);
    config.has_accelerometers = true;
  }
  config.joint_impedance.K_theta = section.K_theta;
  config.cartesian_impedance.K_x = section.K_x;
  config.collision_behavior = section.collision_behavior;
  config.guiding_mode = section.guiding_mode;
  config.stiffness_frame.EE_T_K = section.EE_T_K.Matrix();
  config.end_effector_frame.NE_T_EE = section.NE_T_EE.Matrix();
  config.load = section.load;
  config.filters = section.filters;
  config.damping_ratio = section.damping_ratio;
  config.abort_after_lost = section.abort_after_lost;
  config.friction_compensation = section.friction_compensation;
  // Without armature the simulated drives have no rotors, and INT must not push against any.
  if (scenario.plant.armature) {
    config.rotor_inertia = scenario.plant.arm.armature.value_or(robot.rotor_inertia);
  }
  config.end_effector = robot.end_effector;
  config.F_T_NE = robot.F_T_NE;
  config.guard_has_hand = scenario.robot.hand != plant::HandKind::kNone;
  config.sensing.measured.has_hand = config.guard_has_hand;
  return config;
}

std::filesystem::path SceneFile(const std::filesystem::path& models,
                                const std::filesystem::path& scene) {
  return models / (scene.empty() ? std::filesystem::path("scenes/floor.xml") : scene);
}

plant::MujocoPlantOptions MakePlant(const scenario::Scenario& scenario,
                                    const scenario::RobotData& robot, const RunFiles& files) {
  plant::MujocoPlantOptions options;
  options.urdf = robot.urdf;
  options.scene = SceneFile(files.models, scenario.scene);
  options.objects = scenario::ObjectsOf(scenario.objects, scenario.seed);
  options.mesh_package = files.mesh_package;
  options.cache = files.cache;
  options.rebuild_cache = files.rebuild_cache;
  options.pose = scenario.robot.pose;
  options.hand = scenario.robot.hand;
  options.friction = scenario.plant.friction;
  options.armature = scenario.plant.armature;
  options.elasticity = scenario.plant.elasticity;
  options.arm = scenario.plant.arm;
  options.mass_scale = scenario.plant.mass_scale;
  options.base_tilt = scenario.plant.base_tilt;
  options.load = scenario.robot.load;
  options.perturbations = scenario.perturbations;
  options.noise.q_rad = scenario.plant.noise_q;
  options.noise.dq_rad_per_s = scenario.plant.noise_dq;
  options.noise.tau_J_Nm = scenario.plant.noise_tau_J;
  options.seed = scenario.seed;
  return options;
}

/// The pose that `step` makes of the one before it.
Transform Stepped(const Transform& last, const scenario::PoseStep& step) {
  Transform next = last;
  if (step.rpy) {
    next = scenario::FramePose{{}, *step.rpy}.Matrix();
  } else if (step.turn != Vector3{}) {
    Transform turned = last;
    turned[12] = turned[13] = turned[14] = 0;
    next = model::Multiply(scenario::FramePose{{}, step.turn}.Matrix(), turned);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    next[12 + i] = step.position ? (*step.position)[i] : last[12 + i] + step.by[i];
  }
  return next;
}

/// The motion must start where the arm rests; the controller would refuse it otherwise.
void RequireStart(const JointVector& q_start, const reference::Trajectory& trajectory) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (std::abs(q_start[i] - trajectory.start()[i]) <= reference::kStartTolerance) continue;
    throw InputError(fmt::format(
        "robot.q_start: joint {} rests at {} rad but the trajectory starts at {} rad; let them "
        "agree within {} rad, or leave q_start out",
        i + 1, q_start[i], trajectory.start()[i], reference::kStartTolerance));
  }
}

/// An event at the motion's end or later would never happen.
template <typename Event>
void RequireBeforeEnd(Duration end, std::string_view key, const std::vector<Event>& events) {
  for (std::size_t i = 0; i < events.size(); ++i) {
    if (events[i].at < end) continue;
    throw InputError(
        fmt::format("{}[{}].at: {} s is not before the end of the motion, {} s; give an earlier "
                    "time, or a longer motion",
                    key, i + 1, ToSeconds(events[i].at), ToSeconds(end)));
  }
}

void RequireScene(const std::filesystem::path& models, const std::filesystem::path& scene) {
  std::error_code error;
  const std::filesystem::path file = SceneFile(models, scene);
  if (std::filesystem::is_regular_file(file, error)) return;
  throw InputError(
      fmt::format("scene: there is no file {}; give an MJCF file beside the scenario, or in the "
                  "models folder",
                  file.string()));
}

/// The names of a scenario that only the program and its data can judge.
scenario::RobotData RequireNames(const scenario::Scenario& scenario, const Catalogue& catalogue,
                                 const RunFiles& files) {
  scenario::At(scenario.places.backend, scenario.backend,
               [&] { (void)catalogue.backends.Find(scenario.backend); });
  if (scenario.controller.library.empty()) {
    scenario::At(scenario.places.controller, scenario.controller.type,
                 [&] { (void)catalogue.controllers.Find(scenario.controller.type); });
  }
  scenario::At(scenario.places.scene, scenario.scene.string(),
               [&] { RequireScene(files.models, scenario.scene); });
  return scenario::At(scenario.places.robot, scenario.robot.model, [&] {
    return scenario::LoadRobotData(files.models, scenario.robot.model, scenario.robot.hand);
  });
}

}  // namespace

bool HasLowPass(const scenario::Scenario& scenario) {
  const setting::Filters& filters = scenario.onboard.filters;
  return scenario.tick.low_pass_hz < loop::TickConfig().low_pass_hz ||
         filters != setting::Filters{.controller_hz = filters.controller_hz};
}

loop::TickConfig MakeTick(const scenario::Scenario& scenario, const scenario::RobotData& robot) {
  const scenario::TickSection& tick = scenario.tick;
  loop::TickConfig config;
  config.generator = tick.generator;
  config.lambda = tick.lambda;
  config.rate_matching = tick.rate_matching;
  config.source_rate_hz = scenario.controller.rate_hz;
  config.finish_tolerance_rad = tick.finish_tolerance;
  config.period_tolerance = tick.period_tolerance;
  config.low_pass_hz = tick.low_pass_hz;
  config.stall_time = tick.stall_time;
  if (tick.limiter) config.limiter = reference::ClientLimits::Of(robot.limits, robot.cartesian);
  config.viability = tick.viability;
  if (!scenario.limits.empty()) config.lab = scenario.limits;
  config.lab_hand = scenario.robot.hand != plant::HandKind::kNone;
  config.limits = robot.limits;
  config.cartesian = robot.cartesian;
  config.cost = tick.cost.Model();
  config.Validate(scenario.motion.interface);
  if (tick.generator == loop::Generator::kRejoining && HasLowPass(scenario)) {
    throw InputError(
        "onboard.filters: they weaken the steps by which tick.generator: rejoining accelerates, and "
        "the arm would creep; leave out all but controller, or say tick.generator: none");
  }
  return config;
}

loop::ControllerLoopConfig MakeControllerLoop(const scenario::ControllerSection& controller) {
  loop::ControllerLoopConfig config;
  config.rate_hz = controller.rate_hz;
  config.clock_ppm = controller.clock_drift_ppm;
  config.phase = controller.phase;
  config.wake_delay = controller.wake_delay.Model();
  config.cost = controller.cost.Model();
  config.feed_forward = controller.feed_forward;
  config.target_noise = controller.target_noise;
  config.Validate();
  return config;
}

MotionModes ModesOf(const scenario::MotionSection& motion) {
  using control::CommandInterface;
  switch (motion.interface) {
    case CommandInterface::kJointPosition:
      return {motion.controller, MotionGeneratorMode::kJointPosition};
    case CommandInterface::kJointVelocity:
      return {motion.controller, MotionGeneratorMode::kJointVelocity};
    case CommandInterface::kCartesianPose:
      return {motion.controller, MotionGeneratorMode::kCartesianPosition};
    case CommandInterface::kTorque:
      return {ControllerMode::kExternalController, MotionGeneratorMode::kJointVelocity};
  }
  return {};
}

JointVector StartOf(const scenario::Scenario& scenario) {
  return scenario.robot.q_start ? *scenario.robot.q_start : scenario.motion.waypoints.front().q;
}

robot::RobotConfig MakeRobotConfig(const scenario::Scenario& scenario,
                                   const scenario::RobotData& robot, const RunFiles& files) {
  robot::RobotConfig config;
  config.protocol = robot.protocol;
  config.onboard = MakeOnboard(scenario, robot);
  config.plant_kind = scenario.plant.kind;
  config.plant = MakePlant(scenario, robot, files);
  if (scenario.base) {
    scenario::BaseData base = scenario::At(scenario.places.base, scenario.base->model, [&] {
      return scenario::LoadBaseData(files.models, scenario.base->model);
    });
    config.plant.base = plant::BaseOptions{std::move(base.urdf), scenario.base->start};
    config.base = base.config;
  }
  config.link = scenario::MakeLink(scenario.link);
  config.q_start = StartOf(scenario);
  RequireStartWithinLimits(scenario, robot, config.q_start);
  config.panel = scenario.panel;
  config.clock_ppm = scenario.robot.clock_drift_ppm;
  config.catch_up = scenario.robot.catch_up;
  config.seed = scenario.seed;
  config.Validate();
  return config;
}

robot::RobotConfig MakeServedConfig(const scenario::Scenario& scenario, const RunFiles& files) {
  const scenario::RobotData robot =
      scenario::LoadRobotData(files.models, scenario.robot.model, scenario.robot.hand);
  robot::RobotConfig config = MakeRobotConfig(scenario, robot, files);
  config.catch_up = {};
  for (faults::DirectionConfig* const direction : {&config.link.state, &config.link.command}) {
    faults::DirectionConfig lossy;  // delays and copies are those of the real wire
    lossy.loss = direction->loss;
    *direction = lossy;
  }
  return config;
}

std::optional<reference::PoseTrajectory> MakePoses(const scenario::Scenario& scenario,
                                                   const scenario::RobotData& robot) {
  const scenario::MotionSection& motion = scenario.motion;
  if (motion.poses.empty()) return std::nullopt;
  const Transform F_T_EE = robot.F_T_EE(scenario.onboard.NE_T_EE);
  reference::PoseWaypoint point;
  point.O_T_EE =
      model::ArmModel::Panda().Pose(model::Frame::kEndEffector, motion.waypoints.front().q, F_T_EE);
  if (motion.poses.front().at) point.at = Duration::zero();
  point.where = motion.waypoints.front().where;
  std::vector<reference::PoseWaypoint> waypoints{point};
  waypoints.reserve(motion.poses.size() + 1);
  for (const scenario::PoseStep& step : motion.poses) {
    point.O_T_EE = Stepped(point.O_T_EE, step);
    point.at = step.at;
    point.where = step.where;
    waypoints.push_back(point);
  }
  return reference::PoseTrajectory(waypoints, motion.timing, robot.cartesian);
}

reference::Trajectory MakeTrajectory(const scenario::Scenario& scenario,
                                     const scenario::RobotData& robot) {
  if (const auto poses = MakePoses(scenario, robot)) {
    reference::Waypoint stand = scenario.motion.waypoints.front();
    stand.at = Duration::zero();
    reference::Waypoint end = stand;
    end.at = poses->duration();
    return reference::Trajectory({stand, end}, {}, robot.limits);
  }
  if (scenario.motion.plan) {
    throw InputError("motion.plan: its points are known only once it is planned, by a run");
  }
  const scenario::MotionSection& motion = scenario.motion;
  reference::Trajectory trajectory(motion.waypoints, motion.timing, robot.limits);
  if (motion.timing.duration || motion.waypoints.front().at) return trajectory;
  const double stretch = EndEffectorStretch(scenario, robot, trajectory);
  if (stretch == 1) return trajectory;
  reference::Timing slower = motion.timing;
  slower.duration = FromSeconds(ToSeconds(trajectory.duration()) * stretch);
  return reference::Trajectory(motion.waypoints, slower, robot.limits);
}

Motion MotionOf(const scenario::Scenario& scenario, const scenario::RobotData& robot,
                reference::Trajectory trajectory) {
  return {.name = {},
          .interface = scenario.motion.interface,
          .impedance = scenario.motion.controller,
          .trajectory = std::move(trajectory),
          .poses = MakePoses(scenario, robot),
          .controller = scenario.controller,
          .tick = scenario.tick,
          .loop = scenario.loop};
}

RobotPlan MakeRobotPlan(const scenario::Scenario& scenario, const Catalogue& catalogue,
                        const RunFiles& files) {
  scenario.Validate();
  scenario::RobotData robot = RequireNames(scenario, catalogue, files);
  robot::RobotConfig config = MakeRobotConfig(scenario, robot, files);
  (void)MakeTick(scenario, robot);  // refuses before anything moves
  return {std::move(robot), std::move(config)};
}

Plan MakePlan(const scenario::Scenario& scenario, const Catalogue& catalogue,
              const RunFiles& files) {
  scenario.Validate();
  if (scenario.application) {
    throw InputError("application: it makes motions of its own, and is no single run");
  }
  scenario::RobotData robot = RequireNames(scenario, catalogue, files);
  (void)MakeTick(scenario, robot);  // refuses before a long search
  std::optional<planning::PlanStatistics> planning;
  reference::Trajectory trajectory =
      scenario.motion.plan
          ? PlanMotion(scenario, robot, *scenario.robot.q_start, files, planning.emplace())
          : MakeTrajectory(scenario, robot);
  robot::RobotConfig config = MakeRobotConfig(scenario, robot, files);
  RequireStart(config.q_start, trajectory);
  RequireBeforeEnd(trajectory.duration(), "hand", scenario.hand);
  if (scenario.base) {
    RequireBeforeEnd(trajectory.duration(), "base.drive", scenario.base->drive);
  }
  Motion motion = MotionOf(scenario, robot, std::move(trajectory));
  return {.robot = std::move(robot),
          .config = std::move(config),
          .motion = std::move(motion),
          .planning = planning};
}

}  // namespace twin::run
