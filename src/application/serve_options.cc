#include "twin/application/serve_options.h"

#include <chrono>
#include <system_error>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/loop/host_timing.h"
#include "twin/reference/viable_axis.h"
#include "twin/run/remote.h"
#include "twin/scenario/data_directory.h"

namespace twin::application {
namespace {

/// Whether or not they are there.
bool IsSameFile(const std::filesystem::path& a, const std::filesystem::path& b) {
  return std::filesystem::weakly_canonical(a) == std::filesystem::weakly_canonical(b);
}

bool IsLockstep(const std::string& drive) {
  return scenario::DriveFromName(drive) == scenario::Drive::kLockstep;
}

scenario::Scenario ScenarioOf(const ServeOptions& options, const std::filesystem::path& models) {
  if (!options.yaml.empty()) {
    return scenario::ParseServed(options.yaml,
                                 options.scenario.empty() ? "the scenario" : options.scenario);
  }
  if (options.scenario.empty()) return run::DefaultServed();
  return scenario::LoadServed(scenario::FindScenario(options.scenario, models));
}

}  // namespace

bool ServeOptions::FreezesWhenIdle() const {
  if (idle == "run") return false;
  if (idle == "freeze") return true;
  throw InputError(fmt::format("{}idle: \"{}\" is neither run nor freeze", dash, idle));
}

record::LogSplit ServeOptions::SplitOfLog() const {
  record::LogSplit split;
  try {
    if (log_split) split = record::ParseLogSplit(*log_split);
    split.keep = log_keep;
    split.is_synced = true;
    return split;
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}log-split: {}", dash, error.what()));
  }
}

void ServeOptions::Validate() const {
  const bool is_realtime = drive && !IsLockstep(*drive);
  const bool is_lockstep = pace || (drive && IsLockstep(*drive));
  const auto refuse_if = [this](bool wrong, std::string_view why) {
    if (wrong) throw InputError(fmt::format(fmt::runtime(why), dash));
  };
  refuse_if(FreezesWhenIdle() && !is_lockstep,
            "{0}idle freeze goes with {0}drive lockstep: the wall clock never stands still");
  refuse_if(clock_ppm && is_lockstep,
            "{0}clock-ppm goes with {0}drive realtime: lockstep has one clock");
  refuse_if(pace && is_realtime, "{0}pace goes with {0}drive lockstep: real time has its own");
  if (pace) RequireInRange(fmt::format("{}pace", dash), *pace, 0.01, 100);
  if (viability) {
    RequireInRange(fmt::format("{}viability", dash), *viability, 0,
                   reference::ViableAxis::kMostLost);
  }
  if (!(session_timeout >= 0.001 && session_timeout <= 3600)) {
    throw InputError(fmt::format("{}session-timeout is {} s; it must lie in [0.001, 3600] s", dash,
                                 session_timeout));
  }
  if (log && capture && IsSameFile(*log, *capture)) {
    throw InputError(fmt::format("{0}log and {0}capture both name {1}; give each a file of its own",
                                 dash, log->string()));
  }
  refuse_if(out && log, "{0}out keeps the log too, as run.mcap; leave out {0}log, or {0}out");
  refuse_if(log_split && !log, "{0}log-split goes with {0}log: it splits that log");
  refuse_if(log_keep && !log_split,
            "{0}log-keep goes with {0}log-split: it counts the files of a split log");
  if (log_keep) RequireInRange(fmt::format("{}log-keep", dash), *log_keep, 1, 1'000'000);
  static_cast<void>(SplitOfLog());
  refuse_if(no_video && !out, "{0}no-video goes with {0}out");
}

ServeDrive DriveOf(const ServeOptions& options) {
  if (options.drive) return {scenario::DriveFromName(*options.drive), options.pace, {}};
  if (options.pace) return {scenario::Drive::kLockstep, options.pace, {}};
  if (options.clock_ppm) return {scenario::Drive::kRealtime, {}, {}};
  constexpr Duration kMeasured = std::chrono::milliseconds(500);
  const loop::JitterVerdict verdict = loop::Evaluate(loop::MeasureJitter(kMeasured));
  if (verdict.good) {
    // Clients need not have the priority that this measurement had.
    const loop::JitterVerdict ordinary =
        loop::EvaluateOrdinary(loop::MeasureOrdinaryWakeUps(kMeasured));
    if (!ordinary.good) return {scenario::Drive::kLockstep, 1.0, ordinary.text};
    return {scenario::Drive::kRealtime, {}, verdict.text};
  }
  return {scenario::Drive::kLockstep, 1.0, verdict.text};
}

scenario::Scenario ServedScenarioOf(const ServeOptions& options, const ServeDrive& drive,
                                    const std::filesystem::path& models) {
  scenario::Scenario scenario = ScenarioOf(options, models);
  if (options.lab) scenario::ApplyLab(scenario::FindLab(*options.lab, models), scenario);
  if (options.seed) scenario.seed = *options.seed;
  if (options.model) scenario.robot.model = *options.model;
  if (options.scene) {
    std::error_code none;
    const bool is_here = std::filesystem::is_regular_file(*options.scene, none);
    scenario.scene = is_here ? std::filesystem::absolute(*options.scene) : *options.scene;
  }
  if (options.clock_ppm) scenario.robot.clock_drift_ppm = *options.clock_ppm;
  scenario.backend = scenario::Scenario().backend;  // the served robot is simulated
  scenario.drive = drive.drive;
  return scenario;
}

ResetPolicy ResetPolicyOf(const ServeOptions& options, const ServeDrive& drive) {
  const std::string& reset = options.reset;
  if (reset == "never") return ResetPolicy::kNever;
  if (reset != "on-connect" && reset != "on-command") {
    throw InputError(fmt::format("{}reset: \"{}\" is none of never, on-connect and on-command",
                                 options.dash, reset));
  }
  if (!drive.is_lockstep()) {
    throw InputError(fmt::format(
        "{0}reset goes with {0}drive lockstep, with {0}pace or without: on the wall clock nothing "
        "begins anew",
        options.dash));
  }
  return reset == "on-connect" ? ResetPolicy::kOnConnect : ResetPolicy::kOnCommand;
}

model::LabLimits GuardOf(const ServeOptions& options, const scenario::Scenario& scenario) {
  if (!options.guard) return {};
  if (!scenario.limits.empty()) return scenario.limits;
  throw InputError(fmt::format(
      "{0}guard: there is nothing to guard, as neither scenario nor lab has a section limits; add "
      "one (docs/reference/limits.md), or leave out {0}guard",
      options.dash));
}

}  // namespace twin::application
