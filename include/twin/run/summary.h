#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "twin/backend/registry.h"
#include "twin/plant/contact_watch.h"
#include "twin/record/cycle_record.h"
#include "twin/report/explanation.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

namespace twin::run {

/// Wall-clock times of a run; they differ from run to run.
struct WallTimes {
  double prepare_s = 0;              ///< scenario read, model composed or taken from the cache
  std::optional<double> planning_s;  ///< part of it: the search for a motion, where one is planned
  double run_s = 0;                  ///< the motion
  double plots_s = 0;
  double video_s = 0;
  double real_time_factor = 0;        ///< simulated time over run_s
  double peak_memory_mb = 0;          ///< largest resident size of the process
  std::uint64_t records_dropped = 0;  ///< realtime: records the log's writer had no room for
};

/// "success", "aborted", "interrupted" or "failed".
[[nodiscard]] std::string OutcomeOf(const RunResult& result, bool interrupted);

/// summary.json: in lockstep it repeats with scenario and seed, byte by byte.
/// @param contacts   of the arm; nullopt without a simulation.
[[nodiscard]] std::string SummaryJson(const scenario::Scenario& scenario, const RunResult& result,
                                      bool interrupted,
                                      const std::optional<plant::ContactWatch>& contacts);

/// summary.json of a run that failed before its first motion.
[[nodiscard]] std::string FailureJson(const scenario::Scenario& scenario,
                                      const std::string& failure);

/// Text of a file. Replaces bytes that are not UTF-8, such as those of a user's file names.
[[nodiscard]] std::string TextOf(const nlohmann::ordered_json& json);

/// Deviation of the arm from its targets, the limits, and whether it exceeded them.
[[nodiscard]] nlohmann::ordered_json DeviationJson(const FollowedMotion& motion);

/// What the scenario sets, as far as it explains an error or is advised against one.
[[nodiscard]] report::ScenarioFacts FactsOf(const scenario::Scenario& scenario);

/// Contacts of the arm; null without a simulation.
[[nodiscard]] nlohmann::ordered_json ContactsJson(
    const std::optional<plant::ContactWatch>& contacts);

/// Counts of the viability filter; null without one.
[[nodiscard]] nlohmann::ordered_json ViabilityJson(
    const std::optional<record::FilterCounts>& counts);

/// As one line of text.
[[nodiscard]] std::string ViabilityText(const record::FilterCounts& counts);

/// timing.json. @param robot  timing of a robot in real time.
[[nodiscard]] std::string TimingJson(const WallTimes& times, const backend::RobotTimings& robot);

/// The summary that a run prints at its end.
[[nodiscard]] std::string SummaryText(const scenario::Scenario& scenario, const RunResult& result,
                                      bool interrupted, const WallTimes& times,
                                      const std::optional<plant::ContactWatch>& contacts);

}  // namespace twin::run
