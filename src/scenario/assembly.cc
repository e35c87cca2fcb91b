#include "twin/scenario/assembly.h"

#include <algorithm>
#include <cmath>
#include <utility>

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

loop::TickConfig MakeTick(const Scenario& scenario) {
  loop::TickConfig config;
  config.generator = scenario.tick.generator;
  config.lambda = scenario.tick.lambda;
  config.rate_matching = scenario.tick.rate_matching;
  config.finish_tolerance_rad = scenario.tick.finish_tolerance;
  config.source_rate_hz = scenario.controller.rate_hz;
  config.cost = scenario.tick.cost.Model();
  config.Validate(scenario.motion.interface);
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
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (std::abs(q_start[i] - trajectory.start()[i]) <= reference::kStartTolerance) continue;
    throw InputError(fmt::format(
        "robot.q_start: joint {} rests at {} rad but the trajectory starts at {} rad; let them "
        "agree within {} rad, or leave q_start out",
        i + 1, q_start[i], trajectory.start()[i], reference::kStartTolerance));
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
  config.Validate();
  return config;
}

reference::Trajectory MakeTrajectory(const Scenario& scenario, const RobotData& robot) {
  return reference::Trajectory(scenario.motion.waypoints, scenario.motion.timing, robot.limits);
}

namespace {

/// What a scenario comes to, short of a compiled model: each part made once and checked.
struct Plan {
  RobotData robot;
  reference::Trajectory trajectory;
  robot::RobotConfig config;
  loop::TickConfig tick;
  loop::ControllerLoopConfig controller_loop;
};

void RequireScene(const std::filesystem::path& models, const std::filesystem::path& scene) {
  std::error_code error;
  if (scene.empty() || std::filesystem::is_regular_file(models / scene, error)) return;
  throw InputError(fmt::format("scene: there is no file {}; give an MJCF file in the models folder",
                               (models / scene).string()));
}

Plan MakePlan(const Scenario& scenario, const Catalogue& catalogue, const RunFiles& files) {
  scenario.Validate();
  (void)catalogue.backends.Find(scenario.backend);
  (void)catalogue.controllers.Find(scenario.controller.type);
  RobotData robot = LoadRobotData(files.models, scenario.robot.model, scenario.robot.hand);
  reference::Trajectory trajectory = MakeTrajectory(scenario, robot);
  robot::RobotConfig config = MakeRobotConfig(scenario, robot, files);
  RequireStart(config.q_start, trajectory);
  const loop::TickConfig tick = MakeTick(scenario);
  const loop::ControllerLoopConfig controller_loop = MakeControllerLoop(scenario.controller);
  RequireScene(files.models, scenario.scene);
  return {std::move(robot), std::move(trajectory), std::move(config), tick, controller_loop};
}

}  // namespace

void Check(const Scenario& scenario, const Catalogue& catalogue, const RunFiles& files) {
  (void)MakePlan(scenario, catalogue, files);
}

class Run::Impl {
 public:
  Impl(const Scenario& scenario, const Catalogue& catalogue, const RunFiles& files,
       rt::RecordSink* sink)
      : scenario_(scenario),
        plan_(MakePlan(scenario, catalogue, files)),
        controller_(catalogue.controllers.Find(scenario.controller.type)(
            {plan_.trajectory, scenario.motion.interface})),
        summary_(sink),
        connection_(catalogue.backends.Find(scenario.backend)(
            {plan_.config, events_, drive_.StateReady(), &summary_})) {}

  RunResult Execute(const RunHooks& hooks);

  const Scenario scenario_;
  const Plan plan_;
  std::unique_ptr<control::Controller> controller_;
  CycleSummary summary_;
  // The backend's robot is on the queue and tells the drive: it must go first.
  rt::EventQueue events_;
  loop::LockstepDrive drive_;
  backend::Connection connection_;
};

RunResult Run::Impl::Execute(const RunHooks& hooks) {
  const Duration planned = plan_.trajectory.duration();
  loop::LockstepRun run{.events = events_,
                        .backend = *connection_.backend,
                        .controller = *controller_,
                        .modes = ModesOf(scenario_.motion.interface),
                        .tick = plan_.tick,
                        .controller_loop = plan_.controller_loop,
                        .seed = scenario_.seed,
                        .time_limit = planned + kBeyondPlan,
                        .sink = &summary_,
                        .progress = {},
                        .event = hooks.event,
                        .interrupted = hooks.interrupted};
  if (hooks.progress) run.progress = [&](Time now) { hooks.progress(now, planned); };
  RunResult result;
  result.report = drive_.Run(run);
  result.goal = plan_.trajectory.goal();
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
  impl_ = std::make_unique<Impl>(scenario, catalogue, files, sink);
}

Run::~Run() = default;

const backend::Connection& Run::connection() const noexcept {
  return impl_->connection_;
}

const reference::Trajectory& Run::trajectory() const noexcept {
  return impl_->plan_.trajectory;
}

const RobotData& Run::robot() const noexcept {
  return impl_->plan_.robot;
}

RunResult Run::Execute(const RunHooks& hooks) {
  return impl_->Execute(hooks);
}

}  // namespace twin::scenario
