#include "experiment/recording.h"

#include <algorithm>
#include <cmath>

#include "experiment/statistics.h"

namespace twin::experiment {
namespace {

Duration PlannedAt(std::size_t cycle, double delay_s) {
  return FromSeconds(static_cast<double>(cycle) * kCycleSeconds - delay_s);
}

}  // namespace

void Recording::Put(const record::CycleRecord& record) noexcept {
  if (record.fate == record::CommandFate::kNone) return;
  cycles_.push_back({.message_id = record.state.message_id,
                     .q = record.state.q,
                     .dq = record.state.dq,
                     .q_d = record.state.q_d,
                     .dq_d = record.state.dq_d,
                     .dddq_d = record.dddq_d,
                     .tau_J_d = record.state.tau_J_d,
                     .fate = record.fate});
}

void Recording::Put(const record::TickRecord& record) noexcept {
  if (record.action != record::TickAction::kWritten) return;
  ticks_.push_back({.message_id = record.message_id,
                    .q_ext = record.q_ext,
                    .dq_ext = record.dq_ext,
                    .q_c = record.command.q_c,
                    .dq_c = record.command.dq_c,
                    .margin = record.margin,
                    .kept_back = record.kept_back});
}

std::vector<double> Signal(const std::vector<CycleSample>& cycles, JointVector CycleSample::*field,
                           std::size_t joint, std::size_t begin, std::size_t end) {
  std::vector<double> signal;
  for (std::size_t k = begin; k < std::min(end, cycles.size()); ++k) {
    signal.push_back((cycles[k].*field)[joint]);
  }
  return signal;
}

std::size_t PlannedCycles(const reference::Trajectory& plan,
                          const std::vector<CycleSample>& cycles) {
  return std::min(cycles.size(), static_cast<std::size_t>(plan.duration() / kCycle));
}

double DelayBehind(const reference::Trajectory& plan, const std::vector<CycleSample>& cycles,
                   JointVector CycleSample::*field) {
  const std::size_t end = PlannedCycles(plan, cycles);
  return LeastSquaresDelay(4, [&](double delay_s) {
    DelaySums sums;
    for (std::size_t k = 0; k < end; ++k) {
      const reference::JointTarget target = plan.Sample(PlannedAt(k, delay_s));
      for (std::size_t j = 0; j < kJoints; ++j) {
        sums.product += (target.q[j] - (cycles[k].*field)[j]) * target.dq[j];
        sums.square += target.dq[j] * target.dq[j];
      }
    }
    return sums;
  });
}

JointVector RmsError(const reference::Trajectory& plan, const std::vector<CycleSample>& cycles,
                     JointVector CycleSample::*field, double delay_s) {
  const std::size_t end = PlannedCycles(plan, cycles);
  JointVector rms{};
  for (std::size_t k = 0; k < end; ++k) {
    const reference::JointTarget target = plan.Sample(PlannedAt(k, delay_s));
    for (std::size_t j = 0; j < kJoints; ++j) {
      rms[j] += std::pow((cycles[k].*field)[j] - target.q[j], 2);
    }
  }
  for (double& x : rms) x = end == 0 ? 0 : std::sqrt(x / static_cast<double>(end));
  return rms;
}

std::array<std::vector<double>, kJoints> PlannedVelocities(const reference::Trajectory& plan) {
  std::array<std::vector<double>, kJoints> velocities;
  for (Duration t{}; t < plan.duration(); t += kCycle) {
    const JointVector dq = plan.Sample(t).dq;
    for (std::size_t j = 0; j < kJoints; ++j) velocities[j].push_back(dq[j]);
  }
  return velocities;
}

}  // namespace twin::experiment
