#include "experiment/jitter_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "experiment/runs.h"

namespace twin::experiment {
namespace {

using control::CommandInterface;

constexpr double kT = kCycleSeconds;
constexpr double kFreeRunningPpm = 50;

/// Jerk of a raw stream, cycle by cycle.
std::vector<JointVector> JerkOf(const reference::Trajectory& plan, const JointLimits& limits,
                                const Stream& stream) {
  std::vector<JointVector> jerk;
  static_cast<void>(RunStream(plan, limits, stream, false, [&](const StreamCycle& cycle) {
    jerk.push_back(cycle.next.dddq_d);
  }));
  return jerk;
}

/// Backward difference of the sampling errors at deposit i, s.
double Difference(const Stream& stream, std::size_t i, int order) {
  if (order == 0) return ToSeconds(SamplingError(stream, i));
  return Difference(stream, i, order - 1) - Difference(stream, i - 1, order - 1);
}

double SumOfSquares(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return sum;
}

}  // namespace

Stream StreamBehind(Remedy remedy, const scenario::RobotData& robot) {
  Stream stream;
  switch (remedy) {
    case Remedy::kNone: break;
    case Remedy::kLimiter: stream.tick = WithLimiter(stream.tick, robot); break;
    case Remedy::kLowPass: stream.tick.low_pass_hz = 100; break;
    case Remedy::kRobotTime: stream.on_robot_time = true; break;
    case Remedy::kGenerator: stream.tick.generator = loop::Generator::kJoint; break;
  }
  return stream;
}

JitterJerk JerkOfJitter(const reference::Trajectory& plan, const JointLimits& limits,
                        CommandInterface interface, double jitter_s, std::uint64_t seed) {
  Stream stream{.interface = interface, .velocity = VelocityFrom::kGiven, .seed = seed};
  const std::vector<JointVector> exact = JerkOf(plan, limits, stream);
  stream.jitter_s = jitter_s;
  const std::vector<JointVector> jittered = JerkOf(plan, limits, stream);
  const bool is_position = interface == CommandInterface::kJointPosition;
  const int order = is_position ? 3 : 2;
  const auto planned = static_cast<std::size_t>(plan.duration() / kCycle);
  JitterJerk result;
  for (std::size_t i = 3; i < std::min({planned, exact.size(), jittered.size()}); ++i) {
    const double middle = (static_cast<double>(i) - 0.5 * order) * kT;
    const reference::JointTarget target = plan.Sample(FromSeconds(middle));
    const double factor = Difference(stream, i, order) / std::pow(kT, order);
    result.t.push_back(static_cast<double>(i) * kT);
    for (std::size_t j = 0; j < kJoints; ++j) {
      result.measured[j].push_back(jittered[i][j] - exact[i][j]);
      result.formula[j].push_back((is_position ? target.dq[j] : target.ddq[j]) * factor);
    }
  }
  double measured = 0;
  double formula = 0;
  double difference = 0;
  for (std::size_t j = 0; j < kJoints; ++j) {
    measured += SumOfSquares(result.measured[j]);
    formula += SumOfSquares(result.formula[j]);
    for (std::size_t i = 0; i < result.t.size(); ++i) {
      difference += std::pow(result.measured[j][i] - result.formula[j][i], 2);
    }
  }
  result.residual = std::sqrt(difference / formula);
  result.ratio = std::sqrt(measured / formula);
  return result;
}

AbortMap MapAborts(const Setting& setting, const scenario::RobotData& robot,
                   const std::vector<double>& jitter_us, const std::vector<double>& speed,
                   int runs) {
  constexpr double kPeakSpeed = 1.875;  // of 1 rad in 1 s
  AbortMap map{.jitter_us = jitter_us, .speed = speed, .runs = runs};
  for (auto& probability : map.probability) probability.resize(jitter_us.size() * speed.size());
  const auto job = [&](int place) {
    const auto index = static_cast<std::size_t>(place);
    const reference::Trajectory plan =
        SecondOfMotion({speed[index / jitter_us.size()] / kPeakSpeed}, robot.limits);
    for (std::size_t way = 0; way < kRemedyNames.size(); ++way) {
      Stream stream = StreamBehind(static_cast<Remedy>(way), robot);
      stream.jitter_s = jitter_us[index % jitter_us.size()] * 1e-6;
      stream.clock_ppm = kFreeRunningPpm;
      const int needed = stream.on_robot_time ? 1 : runs;  // there is nothing random in it
      int aborts = 0;
      for (int run = 0; run < needed; ++run) {
        stream.seed = SeedOfRun(setting, place * runs + run);
        stream.phase = FromSeconds(kT * ChoiceOfRun(setting, place * runs + run));
        if (RunStream(plan, robot.limits, stream, true).aborted) ++aborts;
      }
      map.probability[way][index] = static_cast<double>(aborts) / needed;
    }
  };
  InParallel(setting, static_cast<int>(jitter_us.size() * speed.size()), job, 0.3, 0.8);
  return map;
}

std::vector<Pace> FindEnd(const Setting& setting, const StreamSetting& streams,
                          const std::vector<double>& shares, int runs) {
  const JointLimits& limits = streams.robot.limits;
  std::vector<std::vector<StreamResult>> results(shares.size());
  for (auto& result : results) result.resize(static_cast<std::size_t>(runs));
  std::vector<reference::Trajectory> plans;
  plans.reserve(shares.size());
  for (const double share : shares) plans.push_back(BriskAt(setting, limits, share));
  const auto job = [&](int number) {
    const auto pace = static_cast<std::size_t>(number / runs);
    Stream stream = StreamBehind(Remedy::kGenerator, streams.robot);
    stream.jitter_s = 4e-6;
    stream.clock_ppm = kFreeRunningPpm;
    stream.seed = SeedOfRun(setting, number);
    stream.phase = CrossingPhase(plans[pace], kFreeRunningPpm, ChoiceOfRun(setting, number));
    results[pace][static_cast<std::size_t>(number % runs)] =
        RunStream(plans[pace], limits, stream, false);
  };
  InParallel(setting, static_cast<int>(shares.size()) * runs, job, 0.8, 1);
  std::vector<Pace> paces;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    Pace pace{.acceleration = Largest(plans[i].peaks().acceleration)};
    for (const StreamResult& result : results[i]) {
      pace.jerk = std::max(pace.jerk, Largest(result.jerk));
      pace.aborted += result.aborted ? 1.0 / runs : 0;
    }
    paces.push_back(pace);
  }
  return paces;
}

double ShareAtLimit(const std::vector<Pace>& paces) noexcept {
  for (std::size_t i = 1; i < paces.size(); ++i) {
    const Pace& below = paces[i - 1];
    const Pace& above = paces[i];
    if (below.jerk > 1 || above.jerk <= 1) continue;
    return below.acceleration +
           (above.acceleration - below.acceleration) * (1 - below.jerk) / (above.jerk - below.jerk);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

Duration CrossingPhase(const reference::Trajectory& plan, double ppm, double choice) {
  const double slid = ppm * 1e-6 * ToSeconds(plan.duration());
  return FromSeconds(std::min(slid, kT) * choice);
}

}  // namespace twin::experiment
