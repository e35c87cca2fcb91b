#include "scenario/cycle_summary.h"

#include <algorithm>

namespace twin::scenario {

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

void CycleSummary::Put(const rt::CycleRecord& record) noexcept {
  AddState(record.state);
  if (record.fate == rt::CommandFate::kServed) ++counts_.served;
  if (record.fate == rt::CommandFate::kHeld) ++counts_.held;
  counts_.dropped += record.dropped;
  counts_.longest_loss = std::max<std::uint64_t>(counts_.longest_loss, record.lost_in_row);
  if (next_ != nullptr) next_->Put(record);
}

void CycleSummary::Put(const rt::TickRecord& record) noexcept {
  if (next_ != nullptr) next_->Put(record);
}

}  // namespace twin::scenario
