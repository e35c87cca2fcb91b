#include "cli/robot_service.h"

#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "cli/shared_flags.h"
#include "twin/core/error.h"
#include "twin/fci/sockets.h"
#include "twin/server/controlled_robot.h"
#include "twin/server/served_robot.h"

namespace twin::cli {
namespace {

void RequireRosTime(const ServeFlags& flags) {
  if (!flags.ros.wanted) return;
  // Without these flags the drive has a pace, and to choose it takes a measurement of the host.
  const bool is_unpaced = flags.drive && !flags.pace &&
                          scenario::DriveFromName(*flags.drive) == scenario::Drive::kLockstep;
  const bool steps = flags.ros.lockstep_hz.has_value();
  if (steps && !(is_unpaced && flags.FreezesWhenIdle())) {
    throw InputError(
        "--ros-lockstep: time stands by --drive lockstep --idle freeze, without --pace: say so");
  }
  if (is_unpaced && !steps) {
    throw InputError(
        "--ros: a robot served in lockstep is as fast as programs answer, and ROS nodes do not "
        "answer states: serve it with --pace 1");
  }
}

}  // namespace

application::ServeHost HostOf(const ServeFlags& flags, const Program& program) {
  application::ServeHost host;
  host.files = FilesOf(flags.data, program);
  Listen(flags.network, host.server);
  host.server.model_library = ModelLibraryOf(program);
  host.programs = program.host.path;
  return host;
}

RobotService::RobotService(ServeFlags flags, application::ServeHost host, const Program& program,
                           Tell tell)
    : flags_(std::move(flags)),
      program_(program),
      tell_(std::move(tell)),
      is_among_others_(host.place != nullptr) {
  RequireRosTime(flags_);  // before the session takes addresses
  host.tell = [this](std::string_view line) {
    tell_(robot_time_.seconds(), line);
    page_->Tell("server", line);
  };
  host.sink = [this](record::RecordSink* records) { return MakePage(records); };
  session_.emplace(flags_, std::move(host));
}

RobotService::~RobotService() {
  Close();  // what looks at the robot, before it goes
}

record::RecordSink* RobotService::MakePage(record::RecordSink* records) {
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

std::string RobotService::Open() {
  if (ros_ != nullptr) ros_->Watch(*session_);
  std::string text = OpenPage();
  if (flags_.control) {
    const bool may_reset = session_->reset() != application::ResetPolicy::kNever;
    control_.emplace(*flags_.control,
                     server::ControlledRobot(session_->robot(), may_reset, !is_among_others_),
                     [this](std::string_view line) { session_->Tell(line); });
  }
  return text;
}

std::string RobotService::OpenPage() {
  if (!page_->is_wanted()) return {};
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
        application::PageOperator::Parts{
            program_.catalogue, session_->files(), page_->channel(),
            [this](planning::CollisionWorld& world) { page_->Arrange(world); },
            session_->drive().pace.value_or(1)},
        scenario, robot.arm(), robot.hand(),
        [this](Time /*at*/, std::string_view kind, std::string_view text) {
          page_->Tell(kind, text);
        });
    operator_->Offer(settings);
  }
  return page_->Open(settings, scenario, {.truth = robot.truth()});
}

page::RunClock RobotService::RunClock() {
  robot::AnswerPacedRobot* const lockstep = session_->robot().lockstep();
  if (is_among_others_) {
    return {.why_not = "several robots have one time, which stands still for none of them"};
  }
  if (lockstep == nullptr) {
    return {.why_not = "only the clock of drive lockstep stands"};
  }
  return {.is_paused = [lockstep] { return lockstep->cycles_left().has_value(); },
          .pause = [lockstep](bool on) { on ? lockstep->Pause() : lockstep->Resume(); },
          .why_not = {}};
}

void RobotService::PressUserStop(bool pressed) {
  try {
    session_->robot().PressUserStop(pressed);
  } catch (const Error& error) {
    page_->Tell("error", error.what());
  }
}

std::string RobotService::Introduce() {
  std::string text = IntroductionOf(flags_, *session_);
  if (ros_ != nullptr) {
    text += ros_->OpenServed(*session_, program_.catalogue,
                             [this](std::string_view line) { session_->Tell(line); });
  }
  return text;
}

void RobotService::Close() {
  control_.reset();
  if (ros_ != nullptr) ros_->Close();
  if (page_) page_->Close("the robot is served no more", page::RunEnd::kDone);
  operator_.reset();
}

void RobotService::End() {
  session_->End([this](std::string_view text) { program_.log->info(text); });
}

void RobotService::WriteResults(Terminal& terminal) {
  if (session_->out() == nullptr) return;
  session_->WriteResults(terminal);
  terminal.Print(fmt::format("  report  {}\n", session_->out()->report().string()));
}

}  // namespace twin::cli
