#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "experiment/runs.h"
#include "experiment/stream.h"

namespace twin::experiment {
namespace {

/// Backward difference of the sampling errors at deposit i, s.
double Difference(const Stream& stream, std::size_t i, int order) {
  if (order == 0) return ToSeconds(SamplingError(stream, i));
  return Difference(stream, i, order - 1) - Difference(stream, i - 1, order - 1);
}

double SumOfSquares(const std::vector<double>& values) {
  return std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
}

}  // namespace

std::vector<onboard::JointReference> ReferencesOf(const reference::Trajectory& plan,
                                                  const JointLimits& limits, const Stream& stream) {
  std::vector<onboard::JointReference> references;
  static_cast<void>(RunStream(plan, limits, stream, false,
                              [&](const StreamCycle& cycle) { references.push_back(cycle.next); }));
  return references;
}

JitterJerk JerkOfJitter(const reference::Trajectory& plan, const JointLimits& limits,
                        control::CommandInterface interface, double jitter_s, std::uint64_t seed) {
  Stream stream{.interface = interface, .velocity = VelocityFrom::kGiven, .seed = seed};
  const std::vector<onboard::JointReference> exact = ReferencesOf(plan, limits, stream);
  stream.jitter_s = jitter_s;
  const std::vector<onboard::JointReference> jittered = ReferencesOf(plan, limits, stream);
  const bool is_position = interface == control::CommandInterface::kJointPosition;
  const int order = is_position ? 3 : 2;
  const auto planned = static_cast<std::size_t>(plan.duration() / kCycle);
  JitterJerk result;
  for (std::size_t i = 3; i < std::min({planned, exact.size(), jittered.size()}); ++i) {
    const double middle = (static_cast<double>(i) - 0.5 * order) * kT;
    const reference::JointTarget target = plan.Sample(FromSeconds(middle));
    const double factor = Difference(stream, i, order) / std::pow(kT, order);
    result.t.push_back(static_cast<double>(i) * kT);
    for (std::size_t j = 0; j < kJoints; ++j) {
      result.measured[j].push_back(jittered[i].dddq_d[j] - exact[i].dddq_d[j]);
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

AbortMap MapAborts(const Config& config, const scenario::RobotData& robot,
                   const std::vector<double>& jitter_us, const std::vector<double>& speed,
                   int runs) {
  const auto aborted = [&](std::size_t row, std::size_t column) {
    const auto plan = SecondOfMotion({speed[row] / kPeakOfSecond}, robot.limits);
    const int first = static_cast<int>(row * jitter_us.size() + column) * runs;
    std::array<double, kRemedyNames.size()> shares{};
    for (std::size_t remedy = 0; remedy < shares.size(); ++remedy) {
      std::vector<StreamResult> results;
      do {
        const Stream stream =
            StreamOfRun(config, static_cast<Remedy>(remedy), robot, jitter_us[column] * 1e-6,
                        kFreeRunningPpm, first + static_cast<int>(results.size()));
        results.push_back(RunStream(plan, robot.limits, stream, true));
        if (stream.on_robot_time) break;  // nothing in it is random
      } while (static_cast<int>(results.size()) < runs);
      shares[remedy] = SummaryOf(results).aborted;
    }
    return shares;
  };
  return {jitter_us, speed, runs,
          MapGrid(config, speed.size(), jitter_us.size(), aborted, 0.3, 0.8).all};
}

std::vector<PaceResult> MeasurePaces(const Config& config, const StreamInputs& inputs,
                                     const std::vector<double>& shares, int runs) {
  const JointLimits& limits = inputs.robot.limits;
  std::vector<reference::Trajectory> plans;
  plans.reserve(shares.size());
  for (const double share : shares) plans.push_back(BriskAt(config, limits, share));
  const auto measure = [&](std::size_t pace, std::size_t run) {
    const int number = static_cast<int>(pace) * runs + static_cast<int>(run);
    Stream stream = StreamOfRun(config, Remedy::kGenerator, inputs.robot, kPaperJitter,
                                kFreeRunningPpm, number);
    stream.phase = PhaseOfOvertaking(plans[pace], kFreeRunningPpm, ChoiceOfRun(config, number));
    return RunStream(plans[pace], limits, stream, false);
  };
  const Grid<StreamResult> results = MapGrid(config, shares.size(), runs, measure, 0.8, 1);
  std::vector<PaceResult> paces;
  for (std::size_t i = 0; i < plans.size(); ++i) {
    const StreamRuns all = SummaryOf(results[i]);
    paces.push_back({Largest(plans[i].peaks().acceleration), all.jerk, all.aborted});
  }
  return paces;
}

double ShareAtLimit(const std::vector<PaceResult>& paces) noexcept {
  for (std::size_t i = 1; i < paces.size(); ++i) {
    const PaceResult& below = paces[i - 1];
    const PaceResult& above = paces[i];
    if (below.jerk > 1 || above.jerk <= 1) continue;
    return below.acceleration +
           (above.acceleration - below.acceleration) * (1 - below.jerk) / (above.jerk - below.jerk);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace twin::experiment
