#include "twin/record/cycle_record.h"

#include <cstddef>

namespace twin::record {

double FilterCounts::kept_back_percent() const noexcept {
  if (commands == 0) return 0;
  return 100 * static_cast<double>(kept_back) / static_cast<double>(commands);
}

void FilterCounts::Add(const TickRecord& tick) noexcept {
  if (!WroteCommand(tick) || !tick.margin) return;
  ++commands;
  kept_back += tick.kept_back != 0 ? 1 : 0;
  for (std::size_t i = 0; i < kJoints; ++i) of_joint[i] += (tick.kept_back >> i) & 1U;
  if (!nearest || *tick.margin < nearest->margin) nearest = {*tick.margin, tick.read};
}

}  // namespace twin::record
