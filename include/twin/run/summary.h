#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "twin/backend/registry.h"
#include "twin/core/time.h"
#include "twin/plant/contact_watch.h"
#include "twin/rt/filter_counts.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

namespace twin::run {

/// Wall-clock figures of a run; they differ from run to run.
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

/// summary.json: what, in lockstep, repeats with scenario and seed, byte by byte.
/// @param contacts   what the arm touched; absent: nobody simulates it.
[[nodiscard]] std::string SummaryJson(const scenario::Scenario& scenario, const RunResult& result,
                                      bool interrupted,
                                      const std::optional<plant::ContactWatch>& contacts);

/// summary.json of a run that failed before its first motion.
[[nodiscard]] std::string FailureJson(const scenario::Scenario& scenario,
                                      const std::string& failure);

/// Text of a file. Texts may hold bytes of a user's file names: what is no UTF-8 is replaced.
[[nodiscard]] std::string TextOf(const nlohmann::ordered_json& json);

/// How far the arm was from its targets, the limits of that, and whether it was above them.
[[nodiscard]] nlohmann::ordered_json DeviationJson(const FollowedMotion& motion);

/// What the arm touched; null when nobody knows.
[[nodiscard]] nlohmann::ordered_json ContactsJson(
    const std::optional<plant::ContactWatch>& contacts);

/// What the viability filter did; null without one.
[[nodiscard]] nlohmann::ordered_json ViabilityJson(const std::optional<rt::FilterCounts>& counts);

/// The same in a line for people.
[[nodiscard]] std::string ViabilityText(const rt::FilterCounts& counts);

/// timing.json: what does not. @param robot  how a robot in real time kept its time.
[[nodiscard]] std::string TimingJson(const WallTimes& times, const backend::RobotTimings& robot);

/// The block a run ends with on the terminal.
[[nodiscard]] std::string SummaryText(const scenario::Scenario& scenario, const RunResult& result,
                                      bool interrupted, const WallTimes& times,
                                      const std::optional<plant::ContactWatch>& contacts);

}  // namespace twin::run
