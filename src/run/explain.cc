#include "twin/run/explain.h"

#include "twin/core/error.h"
#include "twin/record/log_reader.h"
#include "twin/run/result_folder.h"
#include "twin/run/summary.h"
#include "twin/scenario/scenario.h"

namespace twin::run {
namespace {

/// Nothing for a scenario that this version does not read.
std::optional<report::ScenarioFacts> FactsIn(const std::filesystem::path& log) {
  const record::LogReader reader(log);
  try {
    return FactsOf(scenario::Parse(reader.run().scenario_yaml, log));
  } catch (const InputError&) {
    return std::nullopt;
  }
}

}  // namespace

report::Explanation Explain(const std::filesystem::path& named, std::optional<std::uint64_t> motion,
                            report::ExplanationParts parts) {
  const std::filesystem::path log = FindLog(named);
  return report::Explain(log, FactsIn(log), motion, parts);
}

}  // namespace twin::run
