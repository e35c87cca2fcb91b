#include "experiment/stream.h"

#include <chrono>
#include <cmath>
#include <numbers>

#include "twin/onboard/limit_monitor.h"
#include "twin/reference/feed_forward.h"

namespace twin::experiment {
namespace {

using control::CommandInterface;
using onboard::JointReference;

constexpr RandomStream kJitterStream{2001};
constexpr RandomStream kNoiseStream{2002};
constexpr Duration kAfterwards = 20 * kCycle;

/// The deposits, one after the other.
class StreamSource {
 public:
  StreamSource(const reference::Trajectory& plan, const Stream& stream)
      : plan_(plan),
        stream_(stream),
        noise_(stream.seed, kNoiseStream),
        period_(FromSeconds(1 / stream.tick.source_rate_hz)),
        feed_forward_(stream.velocity == VelocityFrom::kNominalTime
                          ? reference::FeedForwardTime::kNominal
                          : reference::FeedForwardTime::kSource,
                      period_) {}

  /// Takes the deposits until `now`. @returns whether there was any.
  bool Advance(Duration now) {
    if (stream_.on_robot_time) {
      Put(now);
      return true;
    }
    bool fresh = false;
    for (Duration own = OwnTime(); DepositedAt(own) <= now; own = OwnTime()) {
      Put(own);
      fresh = true;
    }
    return fresh;
  }

  [[nodiscard]] bool has_deposit() const noexcept { return count_ > 0; }
  [[nodiscard]] const reference::JointTarget& target() const noexcept { return target_; }
  [[nodiscard]] Time source_time() const noexcept { return Time(source_time_); }

 private:
  [[nodiscard]] Duration OwnTime() const noexcept {
    return static_cast<std::int64_t>(count_) * period_ + SamplingError(stream_, count_);
  }

  [[nodiscard]] Duration DepositedAt(Duration own) const noexcept {
    return stream_.phase + FromSeconds(ToSeconds(own) / (1 + stream_.clock_ppm * 1e-6));
  }

  void Put(Duration own) noexcept {
    source_time_ = own;
    target_ = plan_.Sample(own);
    if (stream_.noise > 0) {
      for (std::uint32_t j = 0; j < kJoints; ++j) {
        target_.q[j] += stream_.noise * (2 * noise_.Uniform(count_, j) - 1);
      }
    }
    const bool forms_velocity = stream_.velocity == VelocityFrom::kSourceTime ||
                                stream_.velocity == VelocityFrom::kNominalTime;
    if (forms_velocity && stream_.interface == CommandInterface::kJointPosition) {
      target_.dq = feed_forward_.Next(Time(own), target_.q).dq;
    }
    ++count_;
  }

  const reference::Trajectory& plan_;
  const Stream& stream_;
  Random noise_;
  Duration period_;
  reference::FeedForward feed_forward_;
  reference::JointTarget target_;
  Duration source_time_{};
  std::uint64_t count_ = 0;
};

/// Adds a cycle.
void Take(const JointReference& next, const JointLimits& limits, StreamResult& result) {
  ++result.cycles;
  for (std::size_t j = 0; j < kJoints; ++j) {
    const double jerk = std::abs(next.dddq_d[j]) / limits.dddq_max[j];
    result.jerk[j] = std::max(result.jerk[j], jerk);
    result.rms_jerk[j] += jerk * jerk;
    result.share[j] = std::max({result.share[j], jerk, std::abs(next.ddq_d[j]) / limits.ddq_max[j],
                                std::abs(next.dq_d[j]) / limits.dq_max[j]});
  }
}

}  // namespace

JointVector MiddleOf(const JointLimits& limits) noexcept {
  JointVector middle{};
  for (std::size_t i = 0; i < kJoints; ++i) middle[i] = (limits.q_min[i] + limits.q_max[i]) / 2;
  return middle;
}

ChainBench::ChainBench(const loop::TickConfig& config, const JointVector& q_d,
                       CommandInterface interface)
    : interface_(interface),
      limits_(config.limits),
      chain_(config, interface),
      target_{.q = q_d},
      reference_(JointReference::Rest(q_d)) {
  Show();
  chain_.Reset(state_);
}

void ChainBench::Show() noexcept {
  ++state_.message_id;
  state_.q_d = reference_.q_d;
  state_.dq_d = reference_.dq_d;
  state_.ddq_d = reference_.ddq_d;
}

const JointReference& ChainBench::Step(const reference::JointTarget& target, bool fresh,
                                       Time source_time, bool is_lost) noexcept {
  reference::Target deposit;
  deposit.joint = target;
  RobotCommand command;
  chain_.Next(state_, deposit, fresh, 1, source_time, command);
  reference_ = is_lost ? reference_.AfterLoss()
               : interface_ == CommandInterface::kJointVelocity
                   ? reference_.AfterVelocity(command.dq_c)
                   : reference_.AfterPosition(command.q_c);
  Show();
  return reference_;
}

void ChainBench::Step(double q_ext, double dq_ext, bool fresh, bool is_lost) noexcept {
  now_ += kCycle;
  if (fresh) source_time_ = now_;
  target_.q[0] = q_ext;
  target_.dq[0] = dq_ext;
  Step(target_, fresh, source_time_, is_lost);
}

double ChainBench::LargestShare() const noexcept {
  return std::max({std::abs(dq_d()) / limits_.dq_max[0], std::abs(ddq_d()) / limits_.ddq_max[0],
                   std::abs(jerk()) / limits_.dddq_max[0]});
}

Duration SamplingError(const Stream& stream, std::uint64_t deposit) noexcept {
  if (stream.jitter_s == 0) return {};
  return FromSeconds(stream.jitter_s * Random(stream.seed, kJitterStream).Normal(deposit));
}

StreamResult RunStream(const reference::Trajectory& plan, const JointLimits& limits,
                       const Stream& stream, bool stops, const TellCycle& tell) {
  StreamSource source(plan, stream);
  ChainBench bench(stream.tick, plan.start(), stream.interface);
  JointVector last_q = plan.start();
  StreamResult result;
  const auto last = static_cast<std::uint64_t>((plan.duration() + kAfterwards) / kCycle);
  for (std::uint64_t k = 0; k <= last; ++k) {
    const bool fresh = source.Advance(static_cast<std::int64_t>(k) * kCycle);
    if (!source.has_deposit()) continue;
    reference::JointTarget consumed = source.target();
    if (stream.velocity == VelocityFrom::kConsumption) {
      for (std::size_t j = 0; j < kJoints; ++j) {
        consumed.dq[j] = (consumed.q[j] - last_q[j]) / kCycleSeconds;
      }
      last_q = consumed.q;
    }
    const JointReference& next = bench.Step(consumed, fresh, source.source_time());
    if (!result.aborted && !onboard::CheckStep(next, limits, k).empty()) result.aborted = k;
    Take(next, limits, result);
    if (tell) tell(k, next);
    if (stops && result.aborted) break;
  }
  for (double& rms : result.rms_jerk) {
    rms = std::sqrt(rms / static_cast<double>(std::max<std::uint64_t>(result.cycles, 1)));
  }
  return result;
}

StreamInputs LoadStreamInputs(const Config& config) {
  const scenario::Scenario scenario = LoadScenario(config, "asynchronous");
  return {RobotOf(config, scenario), PlanOf(config, scenario)};
}

Stream StreamBehind(Remedy remedy, const scenario::RobotData& robot) {
  Stream stream;
  switch (remedy) {
    case Remedy::kNone: break;
    case Remedy::kLimiter: stream.tick = WithLimiter(stream.tick, robot); break;
    case Remedy::kLowPass: stream.tick.low_pass_hz = 100; break;
    case Remedy::kRobotTime: stream.on_robot_time = true; break;
    case Remedy::kRateMatching: stream.tick.source_rate_hz = 125; break;
    case Remedy::kGivenVelocity: stream.velocity = VelocityFrom::kGiven; [[fallthrough]];
    case Remedy::kGenerator: stream.tick.generator = loop::Generator::kJoint; break;
  }
  return stream;
}

reference::Trajectory BriskAt(const Config& config, const JointLimits& limits, double share) {
  const scenario::MotionSection motion = BriskMotion(config, 1);
  const reference::Trajectory brisk(motion.waypoints, motion.timing, limits);
  const double stretch = std::sqrt(Largest(brisk.peaks().acceleration) / share);
  return {BriskMotion(config, stretch).waypoints, {}, limits};
}

reference::Trajectory SecondOfMotion(const JointVector& displacement, const JointLimits& limits) {
  constexpr double kPi = std::numbers::pi;
  const JointVector ready{0, -kPi / 4, 0, -3 * kPi / 4, 0, kPi / 2, kPi / 4};
  JointVector goal = ready;
  for (std::size_t j = 0; j < kJoints; ++j) goal[j] += displacement[j];
  return {{{.q = ready, .at = Duration::zero()}, {.q = goal, .at = std::chrono::seconds(1)}},
          {},
          limits};
}

Duration PhaseOfOvertaking(const reference::Trajectory& plan, double ppm, double choice) {
  const double slid = ppm * 1e-6 * ToSeconds(plan.duration());
  return FromSeconds(std::min(slid, kCycleSeconds) * choice);
}

loop::TickConfig WithLimiter(loop::TickConfig tick, const scenario::RobotData& robot) {
  tick.limiter = reference::ClientLimits::Of(robot.limits, robot.cartesian);
  return tick;
}

Stream StreamOfRun(const Config& config, Remedy remedy, const scenario::RobotData& robot,
                   double jitter_s, double ppm, int run) {
  Stream stream = StreamBehind(remedy, robot);
  stream.jitter_s = jitter_s;
  stream.clock_ppm = ppm;
  stream.phase = PhaseOfRun(config, run);
  stream.seed = SeedOfRun(config, run);
  return stream;
}

StreamRuns SummaryOf(std::span<const StreamResult> results) {
  const auto runs = static_cast<double>(results.size());
  StreamRuns all;
  for (const StreamResult& result : results) {
    all.aborted += result.aborted ? 1 : 0;
    all.jerk = std::max(all.jerk, Largest(result.jerk));
    all.rms_jerk += Largest(result.rms_jerk) / runs;
  }
  all.aborted /= runs;
  return all;
}

double Largest(const JointVector& values) noexcept {
  return *std::ranges::max_element(values);
}

}  // namespace twin::experiment
