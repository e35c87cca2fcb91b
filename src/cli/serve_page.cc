#include "cli/serve_page.h"

#include <utility>

#include <fmt/format.h>

#include "cli/run_page.h"
#include "cli/run_records.h"
#include "twin/core/error.h"

namespace twin::cli {

void ServePage::Open(const scenario::Scenario& scenario, const scenario::RobotData& data,
                     const run::Catalogue& catalogue, const run::RunFiles& files,
                     server::ServedRobot& robot) {
  if (!flags_.wanted()) return;
  const bool is_lockstep = scenario.drive == scenario::Drive::kLockstep;
  page::PageSettings settings = PageAt(flags_);
  settings.title = scenario.name.empty() ? "panda-twin serve" : scenario.name;
  settings.about = fmt::format("{}, served at {}, drive {}", scenario.robot.model,
                               fci::ToString(robot.arm()), Name(scenario.drive));
  settings.limits = data.limits;
  settings.stop = [this, &robot] { Press(robot, true); };
  settings.release = [this, &robot] { Press(robot, false); };
  page::PageScene scene;
  if (robot.truth() != nullptr && RunRecords::CanFilm(*robot.truth())) {
    scene.truth = robot.truth();
    scene.views = PageViews(scenario);
    feed_.Show(*robot.truth());
  }
  if (is_lockstep) {
    settings.watch_only = "a robot served in lockstep waits for programs; people watch";
  } else {
    settings.control = [this](bool wanted) { operator_->Operate(wanted); };
    settings.sample = [this](const teleop::OperatorSample& sample) { recording_.Take(sample); };
    settings.record = [this](bool on) { return recording_.Switch(on); };
    operator_ = std::make_unique<PageOperator>(
        PageOperator::Parts{catalogue, files, channel_}, scenario, robot.arm(),
        [this](Time at, std::string_view kind, std::string_view text) {
          page_->Tell(at, kind, text);
        });
  }
  page_ = std::make_unique<page::LivePage>(settings, scene, feed_, channel_);
  TellPage(*page_, flags_);
}

void ServePage::Press(server::ServedRobot& robot, bool pressed) {
  try {
    robot.PressUserStop(pressed);
  } catch (const Error& error) {
    page_->Tell({}, "error", error.what());
  }
}

void ServePage::Tell(Time at, std::string_view text) {
  if (page_) page_->Tell(at, "server", text);
}

void ServePage::Close() {
  if (page_) page_->End("the robot is served no more");
  operator_.reset();
  page_.reset();
}

}  // namespace twin::cli
