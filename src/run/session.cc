#include "twin/run/session.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "run/hand_script.h"
#include "run/prepared_motion.h"
#include "run/resolve.h"
#include "run/session_core.h"
#include "twin/core/check.h"
#include "twin/core/error.h"
#include "twin/scenario/names.h"

namespace twin::run {
namespace {

/// At rest is slower than this, rad/s ...
constexpr double kRestSpeed = 0.01;
/// ... for so long.
constexpr Duration kRestTime = std::chrono::milliseconds(50);
/// For an arm to come to rest, and for a robot to recover.
constexpr Duration kTimeout = std::chrono::seconds(5);

/// A scenario without waypoints gets two where its arm rests.
scenario::Scenario Standing(scenario::Scenario scenario) {
  scenario.application.reset();
  scenario.operator_section.reset();
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

}  // namespace

class Session::Impl {
 public:
  Impl(const scenario::Scenario& scenario, const Catalogue& catalogue, const RunFiles& files,
       rt::RecordSink* sink, const RealtimeSettings& settings)
      : controllers_(catalogue.controllers),
        core_(scenario, MakeRobotPlan(scenario, catalogue, files), catalogue, sink, settings) {}

  [[nodiscard]] SessionCore& core() noexcept { return core_; }
  [[nodiscard]] Time Now() const { return core_.setting().Now(); }

  MotionResult Move(const Motion& motion) {
    PreparedMotion prepared(As(core_.scenario(), motion), core_.robot(), motion, controllers_);
    return core_.Move(prepared, motion.attend);
  }
  HandOutcome Command(const HandCommand& command, Duration limit);
  WaitEnd Wait(Duration limit, const std::function<bool(const RobotState&)>& done);
  void Recover();

  bool begun = false;
  std::optional<SessionResult> result;

 private:
  /// Lets time pass until then, at least. @returns whether it did, and was not interrupted.
  [[nodiscard]] bool PassUntil(Time time);

  const control::ControllerRegistry& controllers_;
  SessionCore core_;
};

bool Session::Impl::PassUntil(Time time) {
  return !core_.setting().PassUntil(
      time, [this](const RobotState* /*state*/) { return core_.interrupted(); });
}

HandOutcome Session::Impl::Command(const HandCommand& command, Duration limit) {
  backend::Hand& hand = core_.RequireHand();
  const Time begin = core_.setting().Now();
  const std::vector<scenario::HandEvent> events{{begin.time_since_epoch(), command}};
  HandScript script(events, hand,
                    [this](Time, std::string_view text) { core_.Tell("hand", text); });
  std::string stopped;
  for (Time next = script.Attend(begin); next != Time::max();
       next = script.Attend(core_.setting().Now())) {
    if (!PassUntil(next)) {
      stopped = "interrupted";
    } else if (core_.setting().Now() - begin >= limit) {
      stopped = fmt::format("{} has not ended within {} s, and was stopped", twin::Name(command),
                            ToSeconds(limit));
    }
    if (stopped.empty()) continue;
    static_cast<void>(hand.Start(hand::Stop()));
    static_cast<void>(script.Attend(core_.setting().Now()));
    break;
  }
  HandOutcome outcome = script.Report().commands.front();
  if (!stopped.empty()) outcome.failure = stopped;
  return outcome;
}

WaitEnd Session::Impl::Wait(Duration limit, const std::function<bool(const RobotState&)>& done) {
  bool is_done = false;
  const bool in_time = core_.setting().PassUntil(Now() + limit, [&](const RobotState* state) {
    is_done = is_done || (state != nullptr && done(*state));
    return is_done || core_.interrupted();
  });
  if (is_done) return WaitEnd::kDone;
  return in_time ? WaitEnd::kInterrupted : WaitEnd::kTimeLimit;
}

void Session::Impl::Recover() {
  RobotState last = core_.NextState();
  if (last.robot_mode == RobotMode::kIdle) return;
  const auto stopped = [&last](const RobotState& state) {
    last = state;
    return state.robot_mode != RobotMode::kReflex || IsSlow(state);
  };
  if (Wait(kTimeout, stopped) == WaitEnd::kInterrupted) return;
  core_.connection().backend->Recover();
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
  if (end == WaitEnd::kDone) core_.Tell("recovery", "done");
}

Session::Session(const scenario::Scenario& scenario, const Catalogue& catalogue,
                 const RunFiles& files, rt::RecordSink* sink, const RealtimeSettings& settings)
    : impl_(std::make_unique<Impl>(Standing(scenario), catalogue, files, sink, settings)) {}

Session::~Session() {
  impl_->core().setting().End();
}

const backend::Connection& Session::connection() const noexcept {
  return impl_->core().connection();
}

backend::MobileBase* Session::base() const noexcept {
  return connection().base;
}

const scenario::RobotData& Session::robot() const noexcept {
  return impl_->core().robot();
}

bool Session::CheckStart(const Motion& first, const TellCheck& tell) {
  SessionCore& core = impl_->core();
  return core.setting().Check(As(core.scenario(), first), core.robot(), first.trajectory.start(),
                              tell);
}

void Session::Begin(const RunHooks& hooks) {
  TWIN_CHECK(!impl_->begun);
  impl_->core().Begin(hooks);
  impl_->begun = true;
}

MotionResult Session::Move(const Motion& motion) {
  TWIN_CHECK(impl_->begun);
  return impl_->Move(motion);
}

HandOutcome Session::Command(const HandCommand& command, Duration limit) {
  TWIN_CHECK(impl_->begun);
  return impl_->Command(command, limit);
}

WaitEnd Session::Wait(Duration limit, const std::function<bool(const RobotState&)>& done) {
  TWIN_CHECK(impl_->begun);
  return impl_->Wait(limit, done);
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

RobotState Session::ReadState() {
  TWIN_CHECK(impl_->begun);
  return impl_->core().NextState();
}

void Session::Recover() {
  TWIN_CHECK(impl_->begun);
  impl_->Recover();
}

void Session::Tell(std::string_view kind, std::string_view text) const {
  impl_->core().Tell(kind, text);
}

Time Session::Now() const {
  return impl_->Now();
}

bool Session::interrupted() const noexcept {
  return impl_->core().interrupted();
}

SessionResult Session::End() {
  if (!impl_->result) impl_->result = impl_->core().End();
  return *impl_->result;
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
    motion.tick.generator = loop::Generator::kRejoining;
  }
  motion.controller.type = interface == control::CommandInterface::kTorque
                               ? "joint_trajectory_effort"
                               : "joint_trajectory";
  return motion;
}

}  // namespace twin::run
