#include "report/target_match.h"

#include <algorithm>

namespace twin::report {

std::optional<TargetMatch::Pair> TargetMatch::Add(const record::CycleRecord& cycle) {
  const std::uint64_t id = cycle.state.message_id;
  measured_[id % kKept] = {id, cycle.at, cycle.state.q};
  const Entry& target = targets_[id % kKept];
  if (target.message_id != id) return std::nullopt;
  return Pair{cycle.at, cycle.state.q, target.q};
}

std::optional<TargetMatch::Pair> TargetMatch::Add(const record::TickRecord& tick) {
  if (std::ranges::all_of(tick.q_ext, [](double x) { return x == 0; })) return std::nullopt;
  const std::uint64_t id = tick.message_id + 1;
  targets_[id % kKept] = {id, {}, tick.q_ext};
  const Entry& measured = measured_[id % kKept];
  if (measured.message_id != id) return std::nullopt;
  return Pair{measured.at, measured.q, tick.q_ext};
}

}  // namespace twin::report
