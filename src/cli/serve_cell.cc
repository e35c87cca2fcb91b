#include "cli/serve_cell.h"

#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "cli/interrupt.h"
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
  RefuseIf(
      flags.lab || flags.model || flags.scene || flags.seed || flags.clock_ppm || flags.log ||
          flags.capture || flags.control || flags.page.wanted() || flags.ros.wanted ||
          flags.network.allow || flags.reset != ServeFlags().reset,
      "this scenario has several robots, which are served to this machine, at 127.0.0.1, "
      "127.0.0.2, ...; --lab, --model, --scene, --seed, --clock-ppm, --log, --capture, --control, "
      "--page, --ros, --allow and --reset are of one");
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
  [[nodiscard]] application::ServeHost HostOf(std::size_t robot);
  void Show(const std::string& robot, std::string_view line);
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
  std::mutex showing_;
  std::deque<application::ServedSession> sessions_;  ///< in the order of the robots
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
    application::ServeOptions options = flags;
    options.scenario = file;
    options.yaml = scenario::ToYaml(cell_.robots[i].scenario);
    if (!is_realtime()) options.drive = "lockstep";
    if (flags.out) options.out = *flags.out / cell_.robots[i].name;
    sessions_.emplace_back(options, HostOf(i));
  }
}

application::ServeHost CellService::HostOf(std::size_t robot) {
  const scenario::CellRobot& one = cell_.robots[robot];
  application::ServeHost host;
  host.files = files_;
  Listen(flags_.network, host.server);
  host.server.address += static_cast<std::uint32_t>(robot);
  host.server.model_library = ModelLibraryOf(program_);
  host.programs = program_.host.path;
  host.place = [this, &one](plant::MujocoPlantOptions& plant) {
    plant.shared = shared_;
    plant.prefix = run::PrefixOf(one);
  };
  host.thread = thread_ ? &*thread_ : nullptr;
  host.tell = [this, &one](std::string_view line) { Show(one.name, line); };
  return host;
}

void CellService::Show(const std::string& robot, std::string_view line) {
  const std::scoped_lock lock(showing_);
  Say(stdout, fmt::format("{}: {}\n", robot, line));
  std::fflush(stdout);
}

bool CellService::Ends() {
  for (std::size_t i = 0; i < sessions_.size(); ++i) {
    for (const std::string& loss : sessions_[i].NewLosses()) {
      program_.log->warn("{}: {}", cell_.robots[i].name, loss);
    }
  }
  if (interrupt_.interrupted()) return true;
  return flags_.seconds && clock_.Now().time_since_epoch() >= FromSeconds(*flags_.seconds);
}

void CellService::End() {
  if (thread_) {
    for (application::ServedSession& session : sessions_) session.robot().StopServing();
    thread_->Stop();
  } else {
    shared_->Release();
  }
  for (application::ServedSession& session : sessions_) {
    session.End([this](std::string_view text) { program_.log->info(text); });
  }
}

int CellService::Run() {
  interrupt_.ThrowIfInterrupted();
  for (application::ServedSession& session : sessions_) session.StartLog();
  for (application::ServedSession& session : sessions_) session.robot().Start();
  if (thread_) {
    for (const std::string& notice : thread_->Start()) program_.log->info("robots: {}", notice);
  }
  for (std::size_t i = 0; i < sessions_.size(); ++i) {
    const std::scoped_lock lock(showing_);
    Say(stdout, fmt::format("{}: {}", cell_.robots[i].name, IntroductionOf(flags_, sessions_[i])));
    std::fflush(stdout);
  }
  constexpr Duration kLook = std::chrono::milliseconds(50);
  while (!Ends()) rt::SleepUntil(clock_, clock_.Now() + kLook);
  const bool is_interrupted = interrupt_.interrupted();
  if (flags_.out) interrupt_.Rearm();  // a second one must not kill what closes the logs
  End();
  if (flags_.out) {
    Terminal terminal(program_.log, program_.is_quiet());
    for (const application::ServedSession& session : sessions_) {
      session.WriteResults(terminal);
      terminal.Print(fmt::format("  report  {}\n", session.out()->report().string()));
    }
  }
  const std::string warnings = sessions_.front().robot().DescribeWarnings();
  if (!warnings.empty()) throw RobotFault("the simulation itself became unsound: " + warnings);
  return is_interrupted ? kInterrupted : kOk;
}

}  // namespace

int ServeCell(const std::filesystem::path& file, const ServeFlags& flags, const Program& program) {
  RequireCellFlags(flags);
  return CellService(file, flags, program).Run();
}

}  // namespace twin::cli
