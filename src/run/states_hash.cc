#include "twin/run/states_hash.h"

#include <variant>

#include "run/cycle_summary.h"
#include "twin/record/log_reader.h"

namespace twin::run {

std::uint64_t StatesHashOf(const std::filesystem::path& log) {
  record::LogReader reader(log);
  CycleSummary summary(nullptr);
  record::LogEntry entry;
  while (reader.Next(entry)) {
    if (const auto* cycle = std::get_if<rt::CycleRecord>(&entry)) summary.Put(*cycle);
  }
  return summary.states_hash();
}

}  // namespace twin::run
