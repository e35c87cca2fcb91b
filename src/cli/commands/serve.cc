#include <atomic>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "cli/commands/commands.h"
#include "cli/interrupt.h"
#include "cli/ros_flags.h"
#include "cli/serve_cell.h"
#include "cli/serve_flags.h"
#include "cli/shared_flags.h"
#include "cli/terminal.h"
#include "twin/application/page_operator.h"
#include "twin/application/served_session.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/core/time.h"
#include "twin/record/cycle_record.h"
#include "twin/reference/viable_axis.h"
#include "twin/run/operator_page.h"
#include "twin/scenario/cell.h"
#include "twin/server/control_channel.h"
#include "twin/server/served_robot.h"

namespace twin::cli {
namespace {

/// Passes a robot's records on, and tells the time of the last cycle.
///
/// Threads: Put() as RecordSink, seconds() any.
class RobotTime final : public record::RecordSink {
 public:
  /// @param next  may be null; must outlive this. Before the robot's time begins.
  void PassTo(record::RecordSink* next) noexcept { next_ = next; }

  void Put(const record::CycleRecord& record) noexcept TWIN_REALTIME override {
    at_.store(record.at, std::memory_order_relaxed);  // publishes nothing else
    if (next_ != nullptr) next_->Put(record);
  }
  void Put(const record::TickRecord& record) noexcept TWIN_REALTIME override {
    if (next_ != nullptr) next_->Put(record);
  }

  [[nodiscard]] double seconds() const noexcept {
    return ToSeconds(at_.load(std::memory_order_relaxed).time_since_epoch());
  }

 private:
  record::RecordSink* next_ = nullptr;
  std::atomic<Time> at_{};
};

/// A served robot, from flags to the end.
class Service {
 public:
  Service(const ServeFlags& flags, const Program& program) : flags_(flags), program_(program) {
    session_.emplace(flags, MakeHost());
  }
  ~Service() {
    CloseRos();
    ClosePage();  // it looks at the robot
  }
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  int Run();

 private:
  [[nodiscard]] application::ServeHost MakeHost();
  /// The page shows the robot's records too.
  [[nodiscard]] record::RecordSink* MakePage(record::RecordSink* records);
  /// An operator who takes control at the page leads the robot, unless it is as fast as programs
  /// answer. STOP presses the robot's user stop, and the operator's release lets it go.
  void OpenPage();
  /// The same clock as the control channel's pause and resume.
  [[nodiscard]] page::RunClock RunClock();
  void PressUserStop(bool pressed);
  void ClosePage();
  /// @throws InputError where time does not pass as ROS nodes need it.
  void RequireRosTime() const;
  void OpenRos();
  void CloseRos();
  /// The results of --out. A second wish to end leaves out the plots and the film that are left.
  void WriteResults();
  /// Threads: any, one at a time.
  void Show(std::string_view line);
  [[nodiscard]] bool Ends();
  [[nodiscard]] bool is_unpaced() const {
    return session_->drive().is_lockstep() && !session_->drive().pace;
  }

  const MonotonicClock clock_;
  const ServeFlags& flags_;
  const Program& program_;
  const InterruptGuard interrupt_;
  std::optional<EventLog> events_;  ///< from Run() to the end
  std::optional<run::OperatorPage> page_;
  RobotTime robot_time_;
  std::optional<application::ServedSession> session_;
  std::optional<server::ControlChannel> control_;  ///< while the robot's time runs
  std::unique_ptr<RosBridge> ros_;                 ///< without --ros: null
  std::unique_ptr<application::PageOperator>
      operator_;  ///< from before the page is open until it has ended
};

application::ServeHost Service::MakeHost() {
  application::ServeHost host;
  host.files = FilesOf(flags_.data, program_);
  Listen(flags_.network, host.server);
  host.server.model_library = ModelLibraryOf(program_);
  host.programs = program_.host.path;
  host.tell = [this](std::string_view line) { Show(line); };
  host.sink = [this](record::RecordSink* records) { return MakePage(records); };
  return host;
}

record::RecordSink* Service::MakePage(record::RecordSink* records) {
  page_.emplace(flags_.page.wanted() ? std::optional(PageAt(flags_.page)) : std::nullopt, records,
                flags_.out.value_or("."),
                [this](std::string_view text) { program_.log->info(text); });
  record::RecordSink* next = page_->sink();
  if (flags_.ros.wanted) {
    ros_ = MakeRosBridge(flags_.ros, next);
    next = ros_->sink();
  }
  robot_time_.PassTo(next);
  return &robot_time_;
}

void Service::Show(std::string_view line) {
  events_->Put(robot_time_.seconds(), line);  // as report, explain and page
  page_->Tell("server", line);
}

void Service::OpenPage() {
  if (!page_->is_wanted()) return;
  const scenario::Scenario& scenario = session_->scenario();
  server::ServedRobot& robot = session_->robot();
  page::PageSettings settings = is_unpaced() ? page::PageSettings() : page_->Recorded();
  settings.title = scenario.name.empty() ? "panda-twin serve" : scenario.name;
  settings.about = fmt::format("{}, served at {}, drive {}", scenario.robot.model,
                               fci::ToString(robot.arm()), scenario.drive_name());
  settings.limits = session_->robot_data().limits;
  settings.stop = [this] { PressUserStop(true); };
  settings.release = [this] { PressUserStop(false); };
  if (session_->out() != nullptr) {
    settings.report = std::filesystem::absolute(session_->out()->report()).string();
  }
  settings.run_clock = RunClock();
  if (is_unpaced()) {
    settings.watch_only =
        "a robot served in lockstep is as fast as programs answer: serve it with --pace 1 to lead "
        "it";
  } else {
    operator_ = std::make_unique<application::PageOperator>(
        application::PageOperator::Parts{program_.catalogue, session_->files(), page_->channel(),
                                         [this] { return page_->FreeBodies(); },
                                         session_->drive().pace.value_or(1)},
        scenario, robot.arm(), robot.hand(),
        [this](Time /*at*/, std::string_view kind, std::string_view text) {
          page_->Tell(kind, text);
        });
    operator_->Offer(settings);
  }
  Say(stdout, page_->Open(settings, scenario, {.truth = robot.truth()}));
  std::fflush(stdout);
}

page::RunClock Service::RunClock() {
  robot::AnswerPacedRobot* const lockstep = session_->robot().lockstep();
  if (lockstep == nullptr) {
    return {.why_not = "only the clock of drive lockstep stands"};
  }
  return {.is_paused = [lockstep] { return lockstep->cycles_left().has_value(); },
          .pause = [lockstep](bool on) { on ? lockstep->Pause() : lockstep->Resume(); },
          .why_not = {}};
}

void Service::PressUserStop(bool pressed) {
  try {
    session_->robot().PressUserStop(pressed);
  } catch (const Error& error) {
    page_->Tell("error", error.what());
  }
}

void Service::ClosePage() {
  if (!page_) return;
  page_->Close("the robot is served no more", page::RunEnd::kDone);
  operator_.reset();
}

void Service::RequireRosTime() const {
  if (!flags_.ros.wanted) return;
  const bool steps = flags_.ros.lockstep_hz.has_value();
  if (steps && !(is_unpaced() && flags_.FreezesWhenIdle())) {
    throw InputError(
        "--ros-lockstep: time stands by --drive lockstep --idle freeze, without --pace: say so");
  }
  if (is_unpaced() && !steps) {
    throw InputError(
        "--ros: a robot served in lockstep is as fast as programs answer, and ROS nodes do not "
        "answer states: serve it with --pace 1");
  }
}

void Service::OpenRos() {
  if (ros_ == nullptr) return;
  events_->Put(ros_->OpenServed(*session_, program_.catalogue,
                                [this](std::string_view line) { session_->Tell(line); }));
}

void Service::CloseRos() {
  if (ros_ != nullptr) ros_->Close();
}

bool Service::Ends() {
  for (const std::string& loss : session_->NewLosses()) program_.log->warn("{}", loss);
  if (interrupt_.interrupted()) return true;
  return flags_.seconds && clock_.Now().time_since_epoch() >= FromSeconds(*flags_.seconds);
}

int Service::Run() {
  server::ServedRobot& robot = session_->robot();
  interrupt_.ThrowIfInterrupted();
  RequireRosTime();
  if (ros_ != nullptr) ros_->Watch(*session_);
  OpenPage();
  events_.emplace(*program_.log_flags);
  if (flags_.control) {
    const bool may_reset = session_->reset() != application::ResetPolicy::kNever;
    control_.emplace(*flags_.control, server::ControlledRobot(robot, may_reset),
                     [this](std::string_view line) { session_->Tell(line); });
  }
  session_->StartLog();
  robot.Begin();
  for (const std::string& notice : robot.notices()) program_.log->info("robot: {}", notice);
  events_->Put(IntroductionOf(flags_, *session_));
  OpenRos();
  robot.Serve([this] { return Ends(); });
  const bool is_interrupted = interrupt_.interrupted();
  if (session_->out() != nullptr)
    interrupt_.Rearm();  // a second one must not kill what closes the log
  control_.reset();
  CloseRos();
  ClosePage();
  session_->End([this](std::string_view text) { program_.log->info(text); });
  if (session_->out() != nullptr) WriteResults();
  const std::string warnings = robot.DescribeWarnings();
  if (!warnings.empty()) throw RobotFault("the simulation itself became unsound: " + warnings);
  return is_interrupted ? kInterrupted : kOk;
}

void Service::WriteResults() {
  events_.reset();  // the terminal writes to standard output
  Terminal terminal(program_.log, program_.is_quiet());
  session_->WriteResults(terminal);
  terminal.Print(fmt::format("  report  {}\n", session_->out()->report().string()));
}

int Serve(const ServeFlags& flags, const Program& program) {
  RequireServeAgreement(flags);
  if (!flags.scenario.empty()) {
    const std::filesystem::path file = ScenarioFile(flags.scenario, flags.data, program.host);
    if (scenario::HasRobots(file)) return ServeCell(file, flags, program);
  }
  return Service(flags, program).Run();
}

}  // namespace

void AddServe(CLI::App& app, Program& program) {
  const auto [serve, flags] = AddCommand(
      app, program, "serve", "Serve a robot to programs made for it (FCI protocol 5)", &Serve);
  Add(serve, "scenario FILE", flags.scenario, "Scenario file (default: the ready pose, no scene)");
  AddLab(serve, flags.lab);
  Add(serve, "--model NAME", flags.model,
      "Arm: panda or fr3, or another folder below models/robots (default: the scenario's, or panda)");
  Add(serve, "--scene FILE", flags.scene,
      "World around the robot (MJCF, here or in the models folder)");
  AddNetwork(serve, flags.network);
  Add(serve, "--drive", flags.drive,
      "Who advances time: realtime or lockstep (default: realtime where this host keeps 1 kHz, "
      "else lockstep --pace 1)");
  Add(serve, "--pace N", flags.pace,
      "lockstep: never faster than N times the wall clock (default: as fast as answers come)");
  Add(serve, "--idle", flags.idle, "lockstep: time between motions: run or freeze")
      ->capture_default_str();
  Add(serve, "--reset", flags.reset,
      "lockstep: begin anew for each client of the arm (on-connect), when ctl says so "
      "(on-command), or never")
      ->capture_default_str();
  Add(serve, "--clock-ppm PPM", flags.clock_ppm, "realtime: drift of the robot's clock");
  Add(serve, "--session-timeout S", flags.session_timeout,
      "lockstep: a motion that is not answered for so long is stopped")
      ->capture_default_str();
  Add(serve, "--viability N", flags.viability,
      "Keep the clients' motions within the limits, whatever up to N commands in a row "
      "are lost; 19 bridges all that no robot aborts for")
      ->check(CLI::Range(0, reference::ViableAxis::kMostLost));
  serve.add_flag(
      "--guard", flags.guard,
      "The robot keeps the limits of scenario and lab: it stops a client's motion, as by "
      "a reflex, before the motion breaks one");
  AddSeed(serve, flags.seed);
  Add(serve, "--out DIR", flags.out,
      "Folder of results: log, report with a row per motion, plots, explanations, video");
  serve.add_flag("--no-video", flags.no_video, "With --out: make no video and no contact sheet");
  Add(serve, "--log FILE", flags.log, "Write every cycle (MCAP)");
  Add(serve, "--log-split TIME|SIZE", flags.log_split,
      "Split the log into FILE_0001, FILE_0002 ..., a new one after so long (1h, robot's time) or so "
      "much (512MiB)");
  Add(serve, "--log-keep N", flags.log_keep,
      "With --log-split: keep the newest N ended files and remove older ones (default: keep all)");
  Add(serve, "--capture FILE", flags.capture, "Keep what goes over the wire (pcapng; see decode)");
  Add(serve, "--control FILE", flags.control,
      "Let programs on this machine pause, step and stop the robot over this Unix socket (see ctl)");
  AddPage(serve, flags.page);
  AddRos(serve, flags.ros);
  Add(serve, "--for S", flags.seconds, "End after so long");
  AddData(serve, flags.data);
}

}  // namespace twin::cli
