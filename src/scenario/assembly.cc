#include "twin/scenario/assembly.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "scenario/cycle_summary.h"
#include "twin/core/error.h"
#include "twin/loop/lockstep_drive.h"
#include "twin/rt/event_queue.h"

namespace twin::scenario {
namespace {

/// What a run may take beyond the planned motion: settling behind the reference generator (time
/// constant 1 s at lambda = 1e-3, so 10 s are 5e-5 of what was left) and connecting.
constexpr Duration kBeyondPlan = std::chrono::seconds(20);

robot::LinkConfig MakeLink(const LinkSection& link) {
  robot::LinkConfig config;
  config.state_delay = link.state_delay.Model();
  config.command_delay = link.command_delay.Model();
  config.state_loss = link.state_loss_percent / 100;
  config.command_loss = link.command_loss_percent / 100;
  config.d_INT = link.d_INT;
  return config;
}

onboard::IntConfig MakeOnboard(const Scenario& scenario, const RobotData& robot) {
  onboard::IntConfig config;
  config.limits = robot.limits;
  config.K_theta = scenario.onboard.K_theta;
  config.damping_ratio = scenario.onboard.damping_ratio;
  config.abort_after_lost = scenario.onboard.abort_after_lost;
  // Without armature the simulated drives have no rotors, and INT must not push against any.
  if (scenario.plant.armature) config.rotor_inertia = robot.rotor_inertia;
  config.end_effector = robot.end_effector;
  config.F_T_NE = robot.F_T_NE;
  return config;
}

plant::MujocoPlantOptions MakePlant(const Scenario& scenario, const RobotData& robot,
                                    const RunFiles& files) {
  plant::MujocoPlantOptions options;
  options.urdf = robot.urdf;
  if (!scenario.scene.empty()) options.scene = files.models / scenario.scene;
  options.mesh_package = files.mesh_package;
  options.cache = files.cache;
  options.rebuild_cache = files.rebuild_cache;
  options.hand = scenario.robot.hand;
  options.friction = scenario.plant.friction;
  options.armature = scenario.plant.armature;
  options.noise.q_rad = scenario.plant.noise_q;
  options.noise.dq_rad_per_s = scenario.plant.noise_dq;
  options.noise.tau_J_Nm = scenario.plant.noise_tau_J;
  options.seed = scenario.seed;
  return options;
}

void RequireInside(const JointVector& q, const JointLimits& limits) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (q[i] >= limits.q_min[i] && q[i] <= limits.q_max[i]) continue;
    throw InputError(fmt::format("robot.q_start: joint {} is at {} rad; it must lie in [{}, {}]",
                                 i + 1, q[i], limits.q_min[i], limits.q_max[i]));
  }
}

loop::TickConfig MakeTick(const Scenario& scenario) {
  loop::TickConfig config;
  config.generator = scenario.tick.generator;
  config.lambda = scenario.tick.lambda;
  config.rate_matching = scenario.tick.rate_matching;
  config.finish_tolerance_rad = scenario.tick.finish_tolerance;
  config.source_rate_hz = scenario.controller.rate_hz;
  config.cost = scenario.tick.cost.Model();
  config.Validate();
  if (config.generator == loop::Generator::kJoint &&
      scenario.motion.interface == control::CommandInterface::kJointVelocity) {
    throw InputError(
        "tick.generator: joint makes positions and does not go with motion.interface: "
        "joint_velocity; say none, or leave it out");
  }
  return config;
}

loop::ControllerLoopConfig MakeControllerLoop(const ControllerSection& controller) {
  loop::ControllerLoopConfig config;
  config.rate_hz = controller.rate_hz;
  config.clock_ppm = controller.clock_drift_ppm;
  config.phase = controller.phase;
  config.wake_delay = controller.wake_delay.Model();
  config.cost = controller.cost.Model();
  config.feed_forward = controller.feed_forward;
  config.Validate();
  return config;
}

MotionModes ModesOf(control::CommandInterface interface) {
  MotionModes modes;
  modes.generator = interface == control::CommandInterface::kJointPosition
                        ? MotionGeneratorMode::kJointPosition
                        : MotionGeneratorMode::kJointVelocity;
  return modes;
}

/// The motion must start where the arm rests; the controller would refuse it otherwise.
void RequireStart(const JointVector& q_start, const reference::Trajectory& trajectory) {
  constexpr double kTolerance = 1e-3;  // rad, what a trajectory controller lets pass
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (std::abs(q_start[i] - trajectory.start()[i]) <= kTolerance) continue;
    throw InputError(fmt::format(
        "robot.q_start: joint {} rests at {} rad but the trajectory starts at {} rad; let them "
        "agree within {} rad, or leave q_start out",
        i + 1, q_start[i], trajectory.start()[i], kTolerance));
  }
}

double LargestDistance(const JointVector& a, const JointVector& b) {
  double largest = 0;
  for (std::size_t i = 0; i < kJoints; ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

}  // namespace

robot::RobotConfig MakeRobotConfig(const Scenario& scenario, const RobotData& robot,
                                   const RunFiles& files) {
  robot::RobotConfig config;
  config.onboard = MakeOnboard(scenario, robot);
  config.plant_kind = scenario.plant.kind;
  config.plant = MakePlant(scenario, robot, files);
  config.link = MakeLink(scenario.link);
  config.q_start = scenario.robot.q_start.value_or(scenario.motion.waypoints.front().q);
  config.seed = scenario.seed;
  RequireInside(config.q_start, robot.limits);
  config.Validate();
  return config;
}

reference::Trajectory MakeTrajectory(const Scenario& scenario, const RobotData& robot) {
  return reference::Trajectory(scenario.motion.waypoints, scenario.motion.timing, robot.limits);
}

void Check(const Scenario& scenario, const Catalogue& catalogue, const RunFiles& files) {
  scenario.Validate();
  (void)catalogue.backends.Find(scenario.backend);
  (void)catalogue.controllers.Find(scenario.controller.type);
  const RobotData robot = LoadRobotData(files.models, scenario.robot.model, scenario.robot.hand);
  RequireStart(MakeRobotConfig(scenario, robot, files).q_start, MakeTrajectory(scenario, robot));
  (void)MakeTick(scenario);
  (void)MakeControllerLoop(scenario.controller);
  std::error_code error;
  const std::filesystem::path scene = files.models / scenario.scene;
  if (!scenario.scene.empty() && !std::filesystem::is_regular_file(scene, error)) {
    throw InputError(fmt::format(
        "scene: there is no file {}; give an MJCF file in the models folder", scene.string()));
  }
}

class Run::Impl {
 public:
  Impl(const Scenario& scenario, const Catalogue& catalogue, const RunFiles& files,
       rt::RecordSink* sink)
      : scenario_(scenario),
        robot_(LoadRobotData(files.models, scenario.robot.model, scenario.robot.hand)),
        trajectory_(MakeTrajectory(scenario, robot_)),
        config_(MakeRobotConfig(scenario, robot_, files)),
        controller_(catalogue.controllers.Find(scenario.controller.type)(
            {trajectory_, scenario.motion.interface})),
        summary_(sink),
        connection_(catalogue.backends.Find(scenario.backend)(
            {config_, events_, drive_.StateReady(), &summary_})) {}

  RunResult Execute(const RunHooks& hooks);

  const Scenario scenario_;
  const RobotData robot_;
  const reference::Trajectory trajectory_;
  const robot::RobotConfig config_;
  std::unique_ptr<control::Controller> controller_;
  CycleSummary summary_;
  // The backend's robot is on the queue and tells the drive: it must go first.
  rt::EventQueue events_;
  loop::LockstepDrive drive_;
  backend::Connection connection_;
};

RunResult Run::Impl::Execute(const RunHooks& hooks) {
  const Duration planned = trajectory_.duration();
  loop::LockstepRun run{.events = events_,
                        .backend = *connection_.backend,
                        .controller = *controller_,
                        .modes = ModesOf(scenario_.motion.interface),
                        .tick = MakeTick(scenario_),
                        .controller_loop = MakeControllerLoop(scenario_.controller),
                        .seed = scenario_.seed,
                        .time_limit = planned + kBeyondPlan,
                        .sink = &summary_,
                        .progress = {},
                        .event = hooks.event,
                        .interrupted = hooks.interrupted};
  if (hooks.progress) run.progress = [&](Time now) { hooks.progress(now, planned); };
  RunResult result;
  result.report = drive_.Run(run);
  result.goal = trajectory_.goal();
  result.final_error = LargestDistance(result.report.q_final, result.goal);
  result.counts = summary_.counts();
  result.states_hash = summary_.states_hash();
  const std::string warnings = connection_.engine_warnings ? connection_.engine_warnings() : "";
  if (!warnings.empty()) {
    result.report.failure = "the simulation itself became unsound: " + warnings;
  }
  return result;
}

Run::Run(const Scenario& scenario, const Catalogue& catalogue, const RunFiles& files,
         rt::RecordSink* sink) {
  Check(scenario, catalogue, files);
  impl_ = std::make_unique<Impl>(scenario, catalogue, files, sink);
}

Run::~Run() = default;

const backend::Connection& Run::connection() const noexcept {
  return impl_->connection_;
}

const reference::Trajectory& Run::trajectory() const noexcept {
  return impl_->trajectory_;
}

const RobotData& Run::robot() const noexcept {
  return impl_->robot_;
}

RunResult Run::Execute(const RunHooks& hooks) {
  return impl_->Execute(hooks);
}

}  // namespace twin::scenario
