#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string_view>

#include "cli/commands.h"
#include "cli/page_operator.h"
#include "cli/page_recording.h"
#include "twin/page/live_feed.h"
#include "twin/page/live_page.h"
#include "twin/page/operator_channel.h"
#include "twin/rt/cycle_record.h"
#include "twin/run/run.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"
#include "twin/server/served_robot.h"

namespace twin::cli {

/// The operator's page of a served robot, where the flags want one; else nothing. Whoever takes
/// control there moves the robot (PageOperator), but not one that is served in lockstep: people
/// cannot keep up with it. STOP presses the robot's user stop, and the operator's release lets it
/// go.
///
/// Threads: one; the sink as LiveFeed.
class ServePage {
 public:
  /// @param log  gets the records too; may be null. @param flags, log  must outlive this.
  ServePage(const PageFlags& flags, rt::RecordSink* log) : flags_(flags), log_(log), feed_(log) {}
  ~ServePage() { Close(); }
  ServePage(const ServePage&) = delete;
  ServePage& operator=(const ServePage&) = delete;

  /// What the robot's records go to; null: nowhere.
  [[nodiscard]] rt::RecordSink* sink() noexcept { return flags_.wanted() ? &feed_ : log_; }

  /// Begins to serve. @param robot  that has not begun; must outlive the page, as the catalogue.
  /// @throws as PageAt and page::LivePage.
  void Open(const scenario::Scenario& scenario, const scenario::RobotData& data,
            const run::Catalogue& catalogue, const run::RunFiles& files,
            server::ServedRobot& robot);

  /// A line for all who look.
  void Tell(Time at, std::string_view text);
  /// Says that it is over, and ends; before the robot does. More than once: no effect.
  void Close();

 private:
  void Press(server::ServedRobot& robot, bool pressed);

  const PageFlags& flags_;
  rt::RecordSink* log_;
  page::LiveFeed feed_;
  page::OperatorChannel channel_;
  PageRecording recording_{".", channel_};
  std::unique_ptr<PageOperator> operator_;  ///< from before the page is open until it has ended
  std::unique_ptr<page::LivePage> page_;    ///< outlives it
};

}  // namespace twin::cli
