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
  hash_.AddWord(state.message_id);
  for (const JointVector* values : {&state.q, &state.dq, &state.tau_J, &state.theta, &state.dtheta,
                                    &state.q_d, &state.dq_d, &state.ddq_d, &state.tau_J_d}) {
    hash_.AddNumbers(values->data(), values->size());
  }
  hash_.AddNumbers(state.O_T_EE.data(), state.O_T_EE.size());
  hash_.AddWord(static_cast<std::uint64_t>(state.robot_mode) << 16 |
                static_cast<std::uint64_t>(state.controller_mode) << 8 |
                static_cast<std::uint64_t>(state.motion_generator_mode));
  hash_.AddWord(state.errors.to_ullong());
  hash_.AddWord(state.reflex_reason.to_ullong());
  hash_.AddNumber(state.control_command_success_rate);
}

void CycleSummary::AddBase(const BaseState& base) noexcept {
  hash_.AddWord(base.message_id);
  hash_.AddWord(static_cast<std::uint64_t>(base.mode));
  for (const double value : {base.odometry.x, base.odometry.y, base.odometry.yaw, base.twist.v,
                             base.twist.w, base.twist_d.v, base.twist_d.w}) {
    hash_.AddNumber(value);
  }
  hash_.AddNumbers(base.dq_wheels.data(), base.dq_wheels.size());
}

void CycleSummary::CountMotion(const record::CycleRecord& record) noexcept {
  const bool moves = record.state.robot_mode == RobotMode::kMove;
  if (moves && !moving_) tally_ = {.motion = {}, .motions = tally_.motions + 1};
  moving_ = moves;
  tally_.motion.Add(record);
  shown_.Publish(tally_);
}

void CycleSummary::Put(const record::CycleRecord& record) noexcept {
  AddState(record.state);
  if (record.base) AddBase(*record.base);
  counts_.Add(record);
  CountMotion(record);
  if (next_ != nullptr) next_->Put(record);
}

void CycleSummary::Put(const record::TickRecord& record) noexcept {
  viability_.Add(record);
  if (next_ != nullptr) next_->Put(record);
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
