#pragma once

#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "twin/application/serve_options.h"
#include "twin/fci/capture.h"
#include "twin/record/cycle_record.h"
#include "twin/run/catalogue.h"
#include "twin/run/console.h"
#include "twin/run/result_folder.h"
#include "twin/run/run_records.h"
#include "twin/run/told_events.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"
#include "twin/server/served_robot.h"

namespace twin::application {

/// What serves a robot: folders, network, and who is told what. All of it must outlive the session.
struct ServeHost {
  run::RunFiles files;
  server::ServerConfig server;  ///< short of on_arm_client and capture
  /// Whether the robot takes the first of 127.0.0.1, 127.0.0.2, ... at which its ports are free;
  /// server.address is then ignored.
  bool takes_free_address = false;
  std::string programs;  ///< search path of gnuplot and ffmpeg, for ServeOptions::out
  /// Changes the options of the robot's plant, as to a place in a model of several; empty: it
  /// stands alone.
  std::function<void(plant::MujocoPlantOptions& plant)> place{};
  /// On the wall clock, the thread that the robot shares with others; null: it has its own.
  rt::FiberThread* thread = nullptr;
  /// Receives each line about connections, motions and refusals; one call at a time, on any thread.
  server::TellPeople tell;
  /// Gives the sink of the robot's records, once. @param records  where they must go on to; null:
  /// nowhere. Empty: they only go there.
  std::function<record::RecordSink*(record::RecordSink* records)> sink{};
};

/// A robot that is served to programs, from a user's options to its results: log, capture and
/// folder.
///
///     construct -> StartLog -> robot().Begin, Serve | Start -> End -> WriteResults
///
/// Threads: one; Tell() from any.
class ServedSession {
 public:
  /// Opens the ports. @throws InputError for options that are wrong; EnvironmentError if a port, a
  /// file or a program is not to be had.
  ServedSession(const ServeOptions& options, ServeHost host);
  ~ServedSession();
  ServedSession(const ServedSession&) = delete;
  ServedSession& operator=(const ServedSession&) = delete;

  [[nodiscard]] server::ServedRobot& robot() noexcept { return *robot_; }
  [[nodiscard]] const scenario::Scenario& scenario() const noexcept { return scenario_; }
  [[nodiscard]] const ServeDrive& drive() const noexcept { return drive_; }
  [[nodiscard]] ResetPolicy reset() const noexcept { return reset_; }
  [[nodiscard]] const run::RunFiles& files() const noexcept { return host_.files; }
  [[nodiscard]] const scenario::RobotData& robot_data() const noexcept { return robot_data_; }
  [[nodiscard]] bool has_log() const noexcept { return options_.log || options_.out; }
  /// Null without ServeOptions::out.
  [[nodiscard]] const run::ResultFolder* out() const noexcept { return out_ ? &*out_ : nullptr; }

  /// As the last thing before the robot's time: an earlier session's results go when nothing can
  /// prevent this one any more.
  void StartLog();
  /// Adds a line to the log, and passes it on. Threads: any.
  void Tell(std::string_view line);
  /// Why log or capture cannot be written any more, each once; for ServeHost's reader.
  [[nodiscard]] std::vector<std::string> NewLosses();

  /// Ends the robot, completes log and capture. @param note  receives a line when something is
  /// missing. @throws EnvironmentError as fci::Capture::Finish.
  void End(const std::function<void(std::string_view)>& note);
  /// The results of ServeOptions::out (application::WriteSessionResults). @pre after End().
  void WriteResults(run::Console& console) const;

 private:
  void PrepareResults();
  void Open();
  /// On the address of `settings`.
  void OpenThere(const robot::RobotConfig& config, server::ServedRobotSettings settings);
  [[nodiscard]] server::ServedRobotSettings MakeSettings();
  /// As the log has it. Without a scenario the motion is the client's alone; the log gets one at
  /// rest, so that it can be read as any other.
  [[nodiscard]] scenario::Scenario LoggedScenario() const;

  const ServeOptions options_;
  ServeHost host_;
  const ServeDrive drive_;
  const ResetPolicy reset_;
  const scenario::Scenario scenario_;
  const scenario::RobotData robot_data_;
  std::optional<run::ResultFolder> out_;
  run::RunRecords records_;  ///< of the log
  run::ToldEvents told_{records_};
  std::optional<fci::Capture> capture_;
  std::mutex telling_;
  bool told_of_log_ = false;
  bool told_of_capture_ = false;
  std::optional<server::ServedRobot> robot_;
};

}  // namespace twin::application
