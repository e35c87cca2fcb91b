#include "run/cycle_summary.h"

#include <algorithm>
#include <variant>

#include "twin/record/log_reader.h"

namespace twin::run {

double CycleCounts::unserved_percent() const noexcept {
  const auto all = static_cast<double>(cycles());
  return all > 0 ? 100 * static_cast<double>(held) / all : 0;
}

void CycleCounts::Add(const record::CycleRecord& record) noexcept {
  if (record.fate == record::CommandFate::kServed) ++served;
  if (record.fate == record::CommandFate::kHeld) ++held;
  dropped += record.dropped;
  longest_loss = std::max<std::uint64_t>(longest_loss, record.lost_in_row);
}

void CycleSummary::AddState(const RobotState& state) noexcept {
  counted_.hash.AddWord(state.message_id);
  for (const JointVector* values : {&state.q, &state.dq, &state.tau_J, &state.theta, &state.dtheta,
                                    &state.q_d, &state.dq_d, &state.ddq_d, &state.tau_J_d}) {
    counted_.hash.AddNumbers(values->data(), values->size());
  }
  counted_.hash.AddNumbers(state.O_T_EE.data(), state.O_T_EE.size());
  counted_.hash.AddWord(static_cast<std::uint64_t>(state.robot_mode) << 16 |
                        static_cast<std::uint64_t>(state.controller_mode) << 8 |
                        static_cast<std::uint64_t>(state.motion_generator_mode));
  counted_.hash.AddWord(state.errors.to_ullong());
  counted_.hash.AddWord(state.reflex_reason.to_ullong());
  counted_.hash.AddNumber(state.control_command_success_rate);
}

void CycleSummary::AddBase(const BaseState& base) noexcept {
  counted_.hash.AddWord(base.message_id);
  counted_.hash.AddWord(static_cast<std::uint64_t>(base.mode));
  for (const double value : {base.odometry.x, base.odometry.y, base.odometry.yaw, base.twist.v,
                             base.twist.w, base.twist_d.v, base.twist_d.w}) {
    counted_.hash.AddNumber(value);
  }
  counted_.hash.AddNumbers(base.dq_wheels.data(), base.dq_wheels.size());
}

void CycleSummary::CountMotion(const record::CycleRecord& record) noexcept {
  const bool moves = record.state.robot_mode == RobotMode::kMove;
  if (moves && !counted_.moving)
    counted_.tally = {.motion = {}, .motions = counted_.tally.motions + 1};
  counted_.moving = moves;
  counted_.tally.motion.Add(record);
  shown_.Publish(counted_.tally);
}

void CycleSummary::Put(const record::CycleRecord& record) noexcept {
  AddState(record.state);
  if (record.base) AddBase(*record.base);
  counted_.counts.Add(record);
  CountMotion(record);
  if (next_ != nullptr) next_->Put(record);
}

void CycleSummary::Put(const record::TickRecord& record) noexcept {
  viability_.Add(record);
  if (next_ == nullptr) return;
  if (ahead_ == Duration::zero()) return next_->Put(record);
  record::TickRecord later = record;
  later.read += ahead_;
  later.written += ahead_;
  next_->Put(later);
}

std::uint64_t StatesHashOf(const std::filesystem::path& log) {
  record::LogReader reader(log);
  CycleSummary summary(nullptr);
  record::LogEntry entry;
  while (reader.Next(entry)) {
    if (const auto* cycle = std::get_if<record::CycleRecord>(&entry)) summary.Put(*cycle);
  }
  return summary.states_hash();
}

}  // namespace twin::run
