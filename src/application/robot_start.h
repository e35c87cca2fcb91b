#pragma once

#include <functional>

#include <nlohmann/json.hpp>

#include "twin/application/record_run.h"
#include "twin/backend/registry.h"
#include "twin/run/remote.h"

namespace twin::application {

/// What precedes the first motion of a remote robot: prints a line per check, and refuses.
///
/// Threads: one thread.
class RobotStart {
 public:
  /// @param inputs  must outlive this.
  explicit RobotStart(const RunInputs& inputs) : inputs_(inputs) {}

  /// Checks that need no robot, then connects, then whether a real arm may move and was rehearsed.
  /// @throws InputError for the first check that fails, without check_only; with it only for a
  /// robot that does not say that it is a twin and is not allowed. As `connect`.
  void Reach(const std::function<const backend::Connection&()>& connect);

  /// Prints the other checks. @throws RobotFault when one failed, here or before; nothing moved.
  void RequireReady(const std::function<bool(const run::TellCheck&)>& check);

  /// Asks the user, where that is demanded. @throws run::Interrupted when the answer is no.
  void Confirm();

  /// For the summary: robot, speed, rehearsal or why none, whether the user was asked.
  [[nodiscard]] nlohmann::ordered_json Record() const;

 private:
  void Print(const run::CheckLine& line);
  void CheckPath();
  void CheckRehearsal();
  void CheckHardware(bool is_twin);

  const RunInputs& inputs_;
  int failed_ = 0;
};

/// "HOST:PORT".
[[nodiscard]] std::string NameOf(const backend::RobotAddress& address);

}  // namespace twin::application
