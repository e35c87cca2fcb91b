#include "cli/serve_cell.h"

#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "cli/interrupt.h"
#include "cli/robot_service.h"
#include "cli/shared_flags.h"
#include "cli/terminal.h"
#include "twin/application/served_session.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/plant/shared_model.h"
#include "twin/rt/fiber_thread.h"
#include "twin/rt/host_time.h"
#include "twin/run/islands.h"
#include "twin/scenario/cell.h"

namespace twin::cli {
namespace {

void RequireCellFlags(const ServeFlags& flags) {
  RefuseIf(flags.lab || flags.model || flags.scene || flags.seed || flags.clock_ppm || flags.log ||
               flags.capture || flags.network.allow || flags.reset != ServeFlags().reset,
           "this scenario has several robots, which are served to this machine, at 127.0.0.1, "
           "127.0.0.2, ...; --lab, --model, --scene, --seed, --clock-ppm, --log, --capture, "
           "--allow and --reset are of one");
  RefuseIf(flags.FreezesWhenIdle(),
           "--idle freeze: several robots have one time, which stands still for none of them");
}

/// The served robots and what they share.
class CellService {
 public:
  CellService(const std::filesystem::path& file, const ServeFlags& flags, const Program& program);

  int Run();

 private:
  [[nodiscard]] bool is_realtime() const {
    return flags_.drive && scenario::DriveFromName(*flags_.drive) == scenario::Drive::kRealtime;
  }
  /// Those of one robot.
  [[nodiscard]] ServeFlags FlagsOf(const std::filesystem::path& file, std::size_t robot) const;
  [[nodiscard]] application::ServeHost HostOf(std::size_t robot);
  [[nodiscard]] std::string Named(std::size_t robot, std::string_view text) const {
    return fmt::format("{}: {}", cell_.robots[robot].name, text);
  }
  [[nodiscard]] bool Ends();
  void End();

  const MonotonicClock clock_;
  const ServeFlags& flags_;
  const Program& program_;
  const InterruptGuard interrupt_;
  const scenario::Cell cell_;
  const run::RunFiles files_;
  std::shared_ptr<plant::SharedModel> shared_;
  /// On the wall clock, of all robots, so that they take their steps together.
  std::optional<rt::FiberThread> thread_;
  std::optional<EventLog> events_;     ///< from Run() to the end
  std::deque<RobotService> services_;  ///< in the order of the robots
};

CellService::CellService(const std::filesystem::path& file, const ServeFlags& flags,
                         const Program& program)
    : flags_(flags),
      program_(program),
      cell_(scenario::LoadServedCell(file)),
      files_(FilesOf(flags.data, program)) {
  run::RequireApartAtStart(cell_, files_);
  std::function<void()> others;  // in lockstep each robot has a thread of its own
  if (is_realtime()) {
    thread_.emplace(rt::ThreadSettings{.name = "twin-int", .fifo_priority = 98},
                    [this] { shared_->Release(); });
    others = rt::FiberThread::GiveWay;
  }
  shared_ = plant::SharedModel::Create(run::PlantsOf(cell_.robots, files_), others);
  for (std::size_t i = 0; i < cell_.robots.size(); ++i) {
    services_.emplace_back(
        FlagsOf(file, i), HostOf(i), program,
        [this, i](double at_s, std::string_view line) { events_->Put(at_s, Named(i, line)); });
  }
}

ServeFlags CellService::FlagsOf(const std::filesystem::path& file, std::size_t robot) const {
  const scenario::CellRobot& one = cell_.robots[robot];
  ServeFlags flags = flags_;
  flags.scenario = file;
  scenario::Scenario scenario = one.scenario;
  scenario.render = cell_.common.render;  // the scene's cameras, for the page
  scenario.render.enabled = false;
  flags.yaml = scenario::ToYaml(scenario);
  if (!is_realtime()) flags.drive = "lockstep";
  if (flags.out) flags.out = *flags.out / one.name;
  if (flags.control) *flags.control += "." + one.name;
  flags.page = PageOf(flags.page, robot);
  flags.ros = RosOf(flags.ros, one.name, robot == 0);
  return flags;
}

application::ServeHost CellService::HostOf(std::size_t robot) {
  application::ServeHost host = cli::HostOf(flags_, program_);
  host.server.address += static_cast<std::uint32_t>(robot);
  host.files.neighbours = {cell_.robots, robot};
  host.place = [this,
                prefix = run::PrefixOf(cell_.robots[robot])](plant::MujocoPlantOptions& plant) {
    plant.shared = shared_;
    plant.prefix = prefix;
  };
  host.thread = thread_ ? &*thread_ : nullptr;
  return host;
}

bool CellService::Ends() {
  for (std::size_t i = 0; i < services_.size(); ++i) {
    for (const std::string& loss : services_[i].session().NewLosses()) {
      program_.log->warn("{}", Named(i, loss));
    }
  }
  if (interrupt_.interrupted()) return true;
  return flags_.seconds && clock_.Now().time_since_epoch() >= FromSeconds(*flags_.seconds);
}

void CellService::End() {
  for (RobotService& service : services_) service.Close();
  if (thread_) {
    for (RobotService& service : services_) service.session().robot().StopServing();
    thread_->Stop();
  } else {
    shared_->Release();
  }
  for (RobotService& service : services_) service.End();
}

int CellService::Run() {
  interrupt_.ThrowIfInterrupted();
  events_.emplace(*program_.log_flags);
  for (std::size_t i = 0; i < services_.size(); ++i) {
    if (const std::string page = services_[i].Open(); !page.empty()) events_->Put(Named(i, page));
  }
  for (RobotService& service : services_) service.session().StartLog();
  for (RobotService& service : services_) service.session().robot().Start();
  if (thread_) {
    for (const std::string& notice : thread_->Start()) program_.log->info("robots: {}", notice);
  }
  for (std::size_t i = 0; i < services_.size(); ++i) {
    events_->Put(Named(i, services_[i].Introduce()));
  }
  constexpr Duration kLook = std::chrono::milliseconds(50);
  while (!Ends()) rt::SleepUntil(clock_, clock_.Now() + kLook);
  const bool is_interrupted = interrupt_.interrupted();
  if (flags_.out) interrupt_.Rearm();  // a second one must not kill what closes the logs
  End();
  events_.reset();  // the terminal writes to standard output
  Terminal terminal(program_.log, program_.is_quiet());
  for (RobotService& service : services_) service.WriteResults(terminal);
  const std::string warnings = services_.front().session().robot().DescribeWarnings();
  if (!warnings.empty()) throw RobotFault("the simulation itself became unsound: " + warnings);
  return is_interrupted ? kInterrupted : kOk;
}

}  // namespace

int ServeCell(const std::filesystem::path& file, const ServeFlags& flags, const Program& program) {
  RequireCellFlags(flags);
  return CellService(file, flags, program).Run();
}

}  // namespace twin::cli
