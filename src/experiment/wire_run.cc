#include "experiment/runs.h"
#include "twin/robot/robot_config.h"
#include "twin/run/remote.h"
#include "twin/server/served_robot.h"

namespace twin::experiment {
namespace {

/// Passes the robot's cycles on and counts them.
class RobotSink final : public record::RecordSink {
 public:
  explicit RobotSink(record::RecordSink* next) : next_(next) {}

  void Put(const record::CycleRecord& record) noexcept override {
    counts_.Add(record);
    if (next_ != nullptr) next_->Put(record);
  }
  void Put(const record::TickRecord& /*record*/) noexcept override {}

  [[nodiscard]] const run::CycleCounts& counts() const noexcept { return counts_; }

 private:
  record::RecordSink* next_;
  run::CycleCounts counts_;
};

/// Passes the workstation's ticks on, and drops its view of the cycles.
class WorkstationSink final : public record::RecordSink {
 public:
  explicit WorkstationSink(record::RecordSink* next) : next_(next) {}

  void Put(const record::CycleRecord& /*record*/) noexcept override {}
  void Put(const record::TickRecord& record) noexcept override {
    if (next_ != nullptr) next_->Put(record);
  }

 private:
  record::RecordSink* next_;
};

}  // namespace

run::RunResult RunOverWire(const Config& config, const scenario::Scenario& scenario,
                           record::RecordSink* sink) {
  scenario::Scenario served = scenario;
  served.robot.clock_drift_ppm -= scenario.controller.clock_drift_ppm;
  RobotSink robot_sink(sink);
  const robot::RobotConfig robot_config = run::MakeServedConfig(served, config.files);
  server::ServedRobot robot(robot_config, robot::MakePlant(robot_config),
                            {.takes_free_ports = true, .sink = &robot_sink});
  robot.Start();

  scenario::Scenario remote = scenario;
  remote.controller.clock_drift_ppm = 0;
  WorkstationSink workstation_sink(sink);
  run::RealtimeSettings settings;
  settings.remote = {.host = "127.0.0.1", .arm_port = robot.arm().port};
  settings.checks_start = false;
  run::RunResult result;
  {
    run::Run run(remote, config.catalogue, config.files, &workstation_sink, settings);
    run::RunHooks hooks;
    hooks.interrupted = config.interrupted;
    result = run.Execute(hooks);
  }
  robot.End();
  result.counts = robot_sink.counts();
  result.report.robot_timings.lateness = robot.lateness();
  result.report.robot_timings.overruns = robot.overruns();
  return result;
}

}  // namespace twin::experiment
