#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "cli/command.h"
#include "cli/ros_flags.h"
#include "cli/serve_flags.h"
#include "cli/terminal.h"
#include "twin/application/page_operator.h"
#include "twin/application/served_session.h"
#include "twin/core/time.h"
#include "twin/page/live_page.h"
#include "twin/record/cycle_record.h"
#include "twin/run/operator_page.h"
#include "twin/server/control_channel.h"

namespace twin::cli {

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

/// Folders, network and programs of a robot that flags want to serve.
[[nodiscard]] application::ServeHost HostOf(const ServeFlags& flags, const Program& program);

/// A served robot, and what its flags put beside it: the operator's page, ROS 2, a control channel.
///
///     construct -> Open -> session().StartLog, robot().Begin | Start -> Introduce -> Close -> End
///
/// Threads: one.
class RobotService {
 public:
  /// Receives lines about connections, motions and refusals, and the robot's time, s. Threads: any,
  /// one at a time.
  using Tell = std::function<void(double at_s, std::string_view line)>;

  /// @param host  short of sink and tell. @throws as application::ServedSession; InputError where
  ///   time does not pass as ROS nodes need it.
  RobotService(ServeFlags flags, application::ServeHost host, const Program& program, Tell tell);
  ~RobotService();
  RobotService(const RobotService&) = delete;
  RobotService& operator=(const RobotService&) = delete;

  [[nodiscard]] application::ServedSession& session() noexcept { return *session_; }

  /// Opens the page and the control channel, and lets the ROS 2 graph see the robot's first cycle.
  /// @returns lines for users.
  [[nodiscard]] std::string Open();
  /// What the robot is and how it is reached: lines. Puts it into the ROS 2 graph.
  /// @pre the robot's time runs.
  [[nodiscard]] std::string Introduce();
  /// Ends what looks at the robot. Idempotent.
  void Close();
  /// Ends the robot, completes log and capture. @pre after Close().
  void End();
  /// Those of --out, if they are wanted. A second wish to end leaves out the plots and the film
  /// that are left. @pre after End().
  void WriteResults(Terminal& terminal);

 private:
  /// The page shows the robot's records too.
  [[nodiscard]] record::RecordSink* MakePage(record::RecordSink* records);
  /// An operator who takes control at the page leads the robot, unless it is as fast as programs
  /// answer. STOP presses the robot's user stop, and the operator's release lets it go.
  [[nodiscard]] std::string OpenPage();
  /// The same clock as the control channel's pause and resume.
  [[nodiscard]] page::RunClock RunClock();
  void PressUserStop(bool pressed);
  [[nodiscard]] bool is_unpaced() const {
    return session_->drive().is_lockstep() && !session_->drive().pace;
  }
  const ServeFlags flags_;
  const Program& program_;
  const Tell tell_;
  const bool is_among_others_;  ///< with whom it shares scene and time
  std::optional<run::OperatorPage> page_;
  RobotTime robot_time_;
  std::unique_ptr<RosBridge> ros_;  ///< null without --ros
  std::optional<application::ServedSession> session_;
  std::optional<server::ControlChannel> control_;  ///< while the robot's time runs
  std::unique_ptr<application::PageOperator>
      operator_;  ///< from before the page is open until it has ended
};

}  // namespace twin::cli
