#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "cli/shared_flags.h"
#include "twin/application/served_session.h"
#include "twin/record/cycle_record.h"

namespace twin::cli {

/// A served robot in the ROS 2 graph.
struct RosFlags {
  bool wanted = false;
  std::string name_space = "/";
  std::string discovery = "localhost";  ///< or "subnet"
  double rate_hz = 100;
  bool arms = false;
  bool header = false;  ///< replies by a header in the payload
};
void AddRos(CLI::App& app, RosFlags& flags);
/// Before anything is done. @throws InputError for flags without --ros, values that are wrong, and
/// for a program that was built without ROS 2.
void RequireRosFlags(const RosFlags& flags);

/// The bridge of a served robot.
///
///     construct -> sink, before the robot is there -> Open -> ... -> destructor, before the robot
class RosBridge {
 public:
  virtual ~RosBridge() = default;
  [[nodiscard]] virtual record::RecordSink* sink() noexcept = 0;
  /// @returns lines for users. @throws as ros2::Bridge.
  [[nodiscard]] virtual std::string Open(application::ServedSession& session,
                                         const run::Catalogue& catalogue,
                                         std::function<void(std::string_view line)> tell) = 0;
  /// Ends what it does, before the robot ends. Idempotent.
  virtual void Close() = 0;
};

/// @param next  receives the robot's records; may be null. @pre flags.wanted
[[nodiscard]] std::unique_ptr<RosBridge> MakeRosBridge(const RosFlags& flags,
                                                       record::RecordSink* next);

}  // namespace twin::cli
