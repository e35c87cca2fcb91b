#include "experiment/wire_run.h"

#include "twin/robot/make_plant.h"
#include "twin/server/served_robot.h"

namespace twin::experiment {
namespace {

/// The robot's end: its cycles, counted.
class RobotSide final : public rt::RecordSink {
 public:
  explicit RobotSide(rt::RecordSink* next) : next_(next) {}

  void Put(const rt::CycleRecord& record) noexcept override {
    counts_.Add(record);
    if (next_ != nullptr) next_->Put(record);
  }
  void Put(const rt::TickRecord& /*record*/) noexcept override {}

  [[nodiscard]] const run::CycleCounts& counts() const noexcept { return counts_; }

 private:
  rt::RecordSink* next_;
  run::CycleCounts counts_;
};

/// The workstation's end: its ticks. What it makes of the states is not looked at.
class WorkstationSide final : public rt::RecordSink {
 public:
  explicit WorkstationSide(rt::RecordSink* next) : next_(next) {}

  void Put(const rt::CycleRecord& /*record*/) noexcept override {}
  void Put(const rt::TickRecord& record) noexcept override {
    if (next_ != nullptr) next_->Put(record);
  }

 private:
  rt::RecordSink* next_;
};

}  // namespace

run::RunResult RunOverWire(const Setting& setting, const scenario::Scenario& scenario,
                           rt::RecordSink* sink) {
  scenario::Scenario served = scenario;
  served.robot.clock_drift_ppm -= scenario.controller.clock_drift_ppm;
  RobotSide robot_side(sink);
  const robot::RobotConfig config = run::MakeServedConfig(served, setting.files);
  server::ServedRobot robot(config, robot::MakePlant(config),
                            {.takes_free_ports = true, .sink = &robot_side});
  robot.Start();

  scenario::Scenario remote = scenario;
  remote.controller.clock_drift_ppm = 0;
  WorkstationSide workstation_side(sink);
  run::RealtimeSettings settings;
  settings.remote = {.host = "127.0.0.1", .arm_port = robot.arm().port};
  settings.checks_start = false;
  run::RunResult result;
  {
    run::Run run(remote, setting.catalogue, setting.files, &workstation_side, settings);
    run::RunHooks hooks;
    hooks.interrupted = setting.interrupted;
    result = run.Execute(hooks);
  }
  robot.End();
  result.counts = robot_side.counts();
  result.report.robot_timings.lateness = robot.lateness();
  result.report.robot_timings.overruns = robot.overruns();
  return result;
}

}  // namespace twin::experiment
