#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "cli/shared_flags.h"
#include "twin/application/served_session.h"
#include "twin/record/cycle_record.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

namespace twin::cli {

/// A served robot in the ROS 2 graph.
struct RosFlags {
  bool wanted = false;
  std::string name_space = "/";
  std::string discovery = "localhost";  ///< or "subnet"
  std::string distro = "jazzy";         ///< "humble", or one since Iron
  double rate_hz = 100;
  std::optional<double> lockstep_hz;
  bool arms = false;
  bool header = false;           ///< replies by a header in the payload
  bool is_among_others = false;  ///< with whom it shares scene and time
  bool has_scene = true;  ///< of several: whether it publishes what they share, /clock and /tf
};
/// Of several robots: names below the robot's; what they share is published once.
[[nodiscard]] RosFlags RosOf(const RosFlags& flags, const std::string& robot, bool has_scene);
/// --ros, and what goes with it.
void AddRos(CLI::App& app, RosFlags& flags);
/// What goes with it, for a command that is nothing without ROS 2.
void AddRosNames(CLI::App& app, RosFlags& flags);
/// Before anything is done. @throws InputError for flags without --ros, values that are wrong, and
/// for a program that was built without ROS 2.
void RequireRosFlags(const RosFlags& flags);

/// A bridge to ROS 2.
///
///     construct -> sink, before the robot is there -> OpenServed | OpenRemote -> ... -> Close
class RosBridge {
 public:
  using Tell = std::function<void(std::string_view line)>;

  virtual ~RosBridge() = default;
  /// For the records of a robot that is served.
  [[nodiscard]] virtual record::RecordSink* sink() noexcept = 0;
  /// Before the served robot's time begins: bodies and pictures come from there.
  virtual void Watch(application::ServedSession& session) = 0;
  /// Both return lines for users. @throws as ros2::Bridge.
  [[nodiscard]] virtual std::string OpenServed(application::ServedSession& session,
                                               const run::Catalogue& catalogue,
                                               const Tell& tell) = 0;
  /// @param client  the scenario of a client of the robot at `settings`.
  [[nodiscard]] virtual std::string OpenRemote(const scenario::Scenario& client,
                                               const run::RealtimeConfig& settings,
                                               const run::RunFiles& files,
                                               const run::Catalogue& catalogue,
                                               const Tell& tell) = 0;
  /// Ends what it does, before the robot ends. Idempotent.
  virtual void Close() = 0;
};

/// @param next  receives a served robot's records; may be null.
[[nodiscard]] std::unique_ptr<RosBridge> MakeRosBridge(const RosFlags& flags,
                                                       record::RecordSink* next);

}  // namespace twin::cli
