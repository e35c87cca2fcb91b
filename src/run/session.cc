#include "twin/run/session.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "run/cycle_summary.h"
#include "run/prepared_motion.h"
#include "run/resolve.h"
#include "run/scripts.h"
#include "run/start_check.h"
#include "twin/core/error.h"
#include "twin/core/random.h"
#include "twin/loop/drive.h"
#include "twin/loop/robot_listener.h"
#include "twin/plant/observers.h"
#include "twin/robot/robot.h"
#include "twin/scenario/names.h"

namespace twin::run {
namespace {

/// At rest is slower than this, rad/s ...
constexpr double kRestSpeed = 0.01;
/// ... for so long.
constexpr Duration kRestTime = std::chrono::milliseconds(50);
/// For an arm to come to rest, and for a robot to recover.
constexpr Duration kTimeout = std::chrono::seconds(5);
/// For reading where a robot stands.
constexpr Duration kGlance = std::chrono::milliseconds(20);

double LargestDistance(const JointVector& a, const JointVector& b) {
  double largest = 0;
  for (std::size_t i = 0; i < kJoints; ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

/// A scenario without waypoints gets two where its arm rests.
scenario::Scenario Standing(scenario::Scenario scenario) {
  scenario.application.reset();
  scenario.operator_section.reset();
  scenario.motion.plan.reset();
  if (!scenario.motion.waypoints.empty()) return scenario;
  if (!scenario.robot.q_start) {
    throw InputError(
        "robot.q_start: a scenario without a motion must say where the arm rests; give it");
  }
  scenario.motion.waypoints.assign(2, {.q = *scenario.robot.q_start});
  return scenario;
}

bool IsSlow(const RobotState& state) {
  return std::ranges::all_of(state.dq, [](double dq) { return std::abs(dq) < kRestSpeed; });
}

/// @returns the drive that the scenario asks for, connected to its robot.
std::unique_ptr<loop::Drive> MakeDrive(const scenario::Scenario& scenario,
                                       const robot::RobotConfig& config,
                                       const backend::Registry& backends, record::RecordSink* sink,
                                       const RealtimeConfig& settings) {
  const backend::Factory& connect = backends.Find(scenario.backend);
  if (scenario.is_remote()) {
    return loop::MakeRemoteDrive(connect, config, sink, settings.remote, settings.threads);
  }
  if (scenario.is_lockstep()) return loop::MakeLockstepDrive(connect, config, sink);
  return loop::MakeRealtimeDrive(connect, config, sink, settings.threads);
}

}  // namespace

Session::Session(const scenario::Scenario& scenario, const Catalogue& catalogue,
                 const RunFiles& files, record::RecordSink* sink, const RealtimeConfig& settings)
    : Session(Standing(scenario), MakeRobotPlan(Standing(scenario), catalogue, files), catalogue,
              sink, settings) {}

Session::Session(const scenario::Scenario& scenario, RobotPlan robot, const Catalogue& catalogue,
                 record::RecordSink* sink, const RealtimeConfig& settings)
    : scenario_(scenario),
      robot_(std::make_unique<RobotPlan>(std::move(robot))),
      settings_(settings),
      controllers_(catalogue.controllers),
      summary_(std::make_unique<CycleSummary>(sink)),
      drive_(MakeDrive(scenario, robot_->config, catalogue.backends, summary_.get(), settings)) {
  if (const plant::TruthProbe* const truth = drive_->connection().truth) {
    plant::RequireFreeStart(*truth);
  }
}

Session::~Session() {
  static_cast<void>(drive_->End());
}

const scenario::RobotData& Session::robot() const noexcept {
  return robot_->robot;
}

bool Session::CheckStart(const Motion& first, const TellCheck& tell) {
  if (!scenario_.is_remote()) return true;
  // The only motion is the scenario's own.
  const scenario::Scenario scenario = first.name.empty() ? scenario_ : As(scenario_, first);
  StartCheck check{.clock = *drive_->wall_clock(),
                   .backend = *drive_->connection().backend,
                   .arrival = *drive_->connection().arrival,
                   .time = drive_->connection().time,
                   .listening = {}};
  check.listening.thread = settings_.threads.communication;
  if (scenario.tick.period_tolerance > Duration::zero()) {
    check.listening.tolerance = scenario.tick.period_tolerance;
  }
  checked_ = RunStartCheck(check, scenario, robot(), first.trajectory.start(), tell);
  return checked_;
}

std::optional<JointVector> Session::ReadCurrentPosition() const {
  if (!scenario_.is_remote()) return std::nullopt;
  const backend::Connection& connection = drive_->connection();
  const loop::ListenReport heard = loop::ListenToRobot(
      *drive_->wall_clock(), *connection.backend, *connection.arrival,
      {.span = kGlance, .tolerance = kCycle, .thread = settings_.threads.communication});
  if (heard.states == 0) return std::nullopt;
  return heard.last.q_d;
}

void Session::Begin(const RunHooks& hooks) {
  TWIN_CHECK(!begun_);
  if (scenario_.is_remote() && settings_.checks_start && !checked_) {
    throw RobotFault("the robot is not moved: not all checks before its first motion are well");
  }
  hooks_ = hooks;
  const robot::Robot* robot = connection().lockstep_robot;
  if (hooks.event && robot != nullptr) {
    hooks_.event = [robot, next = hooks.event](Time at, std::string_view kind,
                                               std::string_view text) {
      next(at + robot->records_ahead(), kind, text);
    };
  }
  drive_->Begin();
  begun_ = true;
}

std::uint64_t Session::SeedOf(std::uint64_t motion) const noexcept {
  if (motion == 0) return scenario_.seed;
  const auto bits = Random(scenario_.seed, RandomStream::kMotionSeed).Bits(motion);
  return static_cast<std::uint64_t>(bits[0]) << 32 | bits[1];
}

RobotState Session::ReadState() {
  TWIN_CHECK(begun_);
  RobotState next;
  const auto came = [&next](const RobotState* state) {
    if (state != nullptr) next = *state;
    return state != nullptr;
  };
  // It gives up by itself when none comes.
  static_cast<void>(drive_->PassUntil(Time::max(), came));
  return next;
}

MotionResult Session::Move(PreparedMotion& motion, const std::function<Time(Time)>& attend) {
  TWIN_CHECK(begun_);
  // In real time, what is queued shows where the robot was when the last one looked.
  if (motions_ > 0 && !scenario_.is_lockstep()) static_cast<void>(ReadState());
  const std::uint64_t seen = summary_->Tally().motions;
  const Duration planned = motion.motion().trajectory.duration();
  MotionResult result;
  result.name = motion.motion().name;
  result.begun = drive_->Now();
  result.planned = planned;
  const Duration planned_end = result.begun.time_since_epoch() + planned;

  loop::MotionRun run = motion.Run(*drive_->connection().backend, SeedOf(motions_++));
  run.sink = summary_.get();
  run.event = hooks_.event;
  run.interrupted = hooks_.interrupted;
  run.silence = drive_->connection().silence;
  run.attend = attend;
  if (hooks_.progress || hooks_.look) {
    run.progress = [this, planned_end](Time now) {
      if (hooks_.look) hooks_.look();
      if (hooks_.progress) hooks_.progress(now, planned_end);
    };
  }
  if (!result.name.empty()) Tell("session", fmt::format("motion {}: {}", motions_, result.name));
  result.report = drive_->Run(run);
  const std::string lost = drive_->connection().why_lost ? drive_->connection().why_lost() : "";
  if (!lost.empty() && !result.report.failure.empty()) result.report.failure += "; " + lost;
  for (const record::TickRecord& tick : result.report.evidence) {
    if (hooks_.event) hooks_.event(tick.read, "evidence", loop::DescribeTick(tick));
  }
  followed_.push_back(
      {.name = result.name,
       .begun = result.begun,
       .deviation = result.report.deviation,
       .limit = LimitOf(scenario_, motion.motion().interface, motion.motion().impedance),
       .succeeded = result.report.succeeded()});
  result.goal = motion.motion().trajectory.goal();
  result.final_error = LargestDistance(result.report.q_final, result.goal);
  result.final_pose_error = motion.PoseErrorAt(result.report.q_final);
  const CycleTally& tally = summary_->Tally();
  if (tally.motions > seen) result.counts = tally.motion;
  return result;
}

SessionResult Session::End() {
  if (result_) return *result_;
  SessionResult& result = result_.emplace();
  result.robot_timings = drive_->End();
  result.motions = motions_;
  result.followed = followed_;
  result.counts = summary_->counts();
  if (scenario_.tick.viability) result.viability = summary_->viability();
  result.states_hash = summary_->states_hash();
  const auto& warnings = drive_->connection().engine_warnings;
  if (warnings) result.unsound = warnings();
  return result;
}

HandOutcome Session::Command(const HandCommand& command, Duration limit) {
  TWIN_CHECK(begun_);
  backend::Hand& hand = RequireHand(drive_->connection(), scenario_.backend);
  const Time begin = drive_->Now();
  const std::vector<scenario::HandEvent> events{{begin.time_since_epoch(), command}};
  HandScript script(events, hand, [this](Time, std::string_view text) { Tell("hand", text); });
  std::string stopped;
  const auto stop = [this](const RobotState* /*state*/) { return Look(); };
  for (Time next = script.Attend(begin); next != Time::max(); next = script.Attend(drive_->Now())) {
    if (drive_->PassUntil(next, stop)) {
      stopped = "interrupted";
    } else if (drive_->Now() - begin >= limit) {
      stopped = fmt::format("{} has not ended within {} s, and was stopped", twin::Name(command),
                            ToSeconds(limit));
    }
    if (stopped.empty()) continue;
    static_cast<void>(hand.Start(hand::Stop()));
    static_cast<void>(script.Attend(drive_->Now()));
    break;
  }
  HandOutcome outcome = script.Report().commands.front();
  if (!stopped.empty()) outcome.failure = stopped;
  return outcome;
}

WaitEnd Session::Wait(Duration limit, const std::function<bool(const RobotState&)>& done) {
  TWIN_CHECK(begun_);
  bool is_done = false;
  const bool in_time = drive_->PassUntil(drive_->Now() + limit, [&](const RobotState* state) {
    is_done = is_done || (state != nullptr && done(*state));
    return is_done || Look();
  });
  if (is_done) return WaitEnd::kDone;
  return in_time ? WaitEnd::kInterrupted : WaitEnd::kTimeLimit;
}

void Session::PassUntil(const std::function<bool()>& done) {
  TWIN_CHECK(begun_);
  static_cast<void>(
      drive_->PassUntil(Time::max(), [&done](const RobotState* /*state*/) { return done(); }));
}

void Session::Recover() {
  RobotState last = ReadState();
  if (last.robot_mode == RobotMode::kIdle) return;
  const auto stopped = [&last](const RobotState& state) {
    last = state;
    return state.robot_mode != RobotMode::kReflex || IsSlow(state);
  };
  if (Wait(kTimeout, stopped) == WaitEnd::kInterrupted) return;
  drive_->connection().backend->Recover();
  const auto idle = [&last](const RobotState& state) {
    last = state;
    return state.robot_mode == RobotMode::kIdle;
  };
  const WaitEnd end = Wait(kTimeout, idle);
  if (end == WaitEnd::kTimeLimit) {
    throw RobotFault(fmt::format(
        "the robot has not recovered within {} s: it is in mode {}, not Idle; see what keeps it",
        ToSeconds(kTimeout), Name(last.robot_mode)));
  }
  if (end == WaitEnd::kDone) Tell("recovery", "done");
}

MotionResult Session::Move(const Motion& motion) {
  PreparedMotion prepared(As(scenario_, motion), robot(), motion, controllers_);
  return Move(prepared, motion.attend);
}

MotionResult Session::MoveOwn(const scenario::Scenario& scenario, const RunFiles& files) {
  planning::PlanStatistics statistics;
  Motion motion =
      MotionOf(scenario, robot(),
               scenario.motion.plan
                   ? PlanMotion(scenario, robot(), *scenario.robot.q_start, files, statistics)
                   : MakeTrajectory(scenario, robot()));
  MotionScripts scripts(scenario, connection(), hooks_);
  motion.attend = scripts.Attend();
  return Move(motion);
}

WaitEnd Session::WaitForRest(Duration limit) {
  std::optional<std::uint64_t> slow_since;
  return Wait(limit, [&slow_since](const RobotState& state) {
    if (!IsSlow(state)) {
      slow_since.reset();
      return false;
    }
    if (!slow_since) slow_since = state.message_id;
    return kCycle * static_cast<std::int64_t>(state.message_id - *slow_since) >= kRestTime;
  });
}

reference::Trajectory StandingFor(const JointVector& q, Duration duration,
                                  const JointLimits& limits) {
  return reference::Trajectory({{.q = q, .at = Duration::zero()}, {.q = q, .at = duration}}, {},
                               limits);
}

Motion MotionOn(const scenario::Scenario& scenario, std::string name,
                control::CommandInterface interface, reference::Trajectory trajectory) {
  Motion motion{.name = std::move(name),
                .interface = interface,
                .trajectory = std::move(trajectory),
                .controller = scenario.controller,
                .tick = scenario.tick,
                .loop = scenario.loop};
  if (interface == control::CommandInterface::kTorque) {
    motion.tick.generator = loop::Generator::kNone;
    motion.tick.viability.reset();
  } else if (!loop::Misfit(motion.tick.generator, interface).empty()) {
    motion.tick.generator =
        HasLowPass(scenario) ? loop::Generator::kNone : loop::Generator::kRejoining;
  }
  motion.controller.type = interface == control::CommandInterface::kTorque
                               ? "joint_trajectory_effort"
                               : "joint_trajectory";
  return motion;
}

}  // namespace twin::run
