#include "run/session_core.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/random.h"

namespace twin::run {
namespace {

double LargestDistance(const JointVector& a, const JointVector& b) {
  double largest = 0;
  for (std::size_t i = 0; i < kJoints; ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

}  // namespace

SessionCore::SessionCore(const scenario::Scenario& scenario, RobotPlan robot,
                         const Catalogue& catalogue, rt::RecordSink* sink,
                         const RealtimeSettings& settings)
    : scenario_(scenario),
      robot_(std::move(robot)),
      summary_(sink),
      setting_(MakeDriveSetting(scenario, catalogue.backends.Find(scenario.backend), robot_.config,
                                &summary_, settings)) {}

backend::Hand& SessionCore::RequireHand() const {
  backend::Hand* hand = connection().hand;
  if (hand != nullptr) return *hand;
  throw InputError(
      fmt::format("hand: the backend {} has no hand; leave the commands out", scenario_.backend));
}

backend::MobileBase& SessionCore::RequireBase() const {
  backend::MobileBase* base = connection().base;
  if (base != nullptr) return *base;
  throw InputError(
      fmt::format("base: the backend {} has no mobile base; leave it out", scenario_.backend));
}

void SessionCore::Begin(const RunHooks& hooks) {
  hooks_ = hooks;
  setting_->Begin();
}

std::uint64_t SessionCore::SeedOf(std::uint64_t motion) const noexcept {
  if (motion == 0) return scenario_.seed;
  const auto bits = Random(scenario_.seed, RandomStream::kMotionSeed).Bits(motion);
  return static_cast<std::uint64_t>(bits[0]) << 32 | bits[1];
}

RobotState SessionCore::NextState() {
  RobotState next;
  const auto came = [&next](const RobotState* state) {
    if (state != nullptr) next = *state;
    return state != nullptr;
  };
  // It gives up by itself when none comes.
  static_cast<void>(setting_->PassUntil(Time::max(), came));
  return next;
}

MotionResult SessionCore::Move(PreparedMotion& motion, std::function<Time(Time)> attend) {
  // In real time, what is queued shows where the robot was when the last one looked.
  if (motions_ > 0 && scenario_.drive != scenario::Drive::kLockstep) static_cast<void>(NextState());
  const std::uint64_t seen = summary_.Tally().motions;
  const Duration planned = motion.motion().trajectory.duration();
  MotionResult result;
  result.name = motion.motion().name;
  result.begun = setting_->Now();
  const Duration planned_end = result.begun.time_since_epoch() + planned;

  loop::MotionRun run = motion.Run(*connection().backend, SeedOf(motions_++));
  run.sink = &summary_;
  run.event = hooks_.event;
  run.interrupted = hooks_.interrupted;
  run.attend = std::move(attend);
  if (hooks_.progress) {
    run.progress = [this, planned_end](Time now) { hooks_.progress(now, planned_end); };
  }
  if (!result.name.empty()) Tell("session", fmt::format("motion {}: {}", motions_, result.name));
  result.report = setting_->Run(run);
  for (const rt::TickRecord& tick : result.report.evidence) {
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
  const CycleTally& tally = summary_.Tally();
  if (tally.motions > seen) result.counts = tally.motion;
  return result;
}

SessionResult SessionCore::End() {
  SessionResult result;
  result.robot_timings = setting_->End();
  result.motions = motions_;
  result.followed = followed_;
  result.counts = summary_.counts();
  if (scenario_.tick.viability) result.viability = summary_.viability();
  result.states_hash = summary_.states_hash();
  const auto& warnings = connection().engine_warnings;
  if (warnings) result.unsound = warnings();
  return result;
}

}  // namespace twin::run
