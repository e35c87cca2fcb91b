#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "run/resolve.h"
#include "twin/backend/registry.h"
#include "twin/core/robot_state.h"
#include "twin/loop/motion_run.h"
#include "twin/loop/run_report.h"
#include "twin/run/remote.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

namespace twin::run {

/// What stands behind motions: the connected backend on its drive's time.
///
///     Begin() -> { Run() | PassUntil() } ... -> End()
///
/// Threads: one thread.
class DriveSetting {
 public:
  virtual ~DriveSetting() = default;
  [[nodiscard]] virtual const backend::Connection& connection() const noexcept = 0;

  /// As scenario::Run::CheckStart; of a simulated robot there is nothing to check.
  /// @param scenario, start  of the first motion; rad.
  [[nodiscard]] virtual bool Check(const scenario::Scenario& /*scenario*/,
                                   const scenario::RobotData& /*robot*/,
                                   const JointVector& /*start*/, const TellCheck& /*tell*/) {
    return true;
  }

  /// Where a robot that this process does not simulate holds itself (q_d, rad), before Begin().
  /// Nothing: it is simulated, or no state came.
  [[nodiscard]] virtual std::optional<JointVector> ReadCurrentPosition() { return std::nullopt; }

  /// Time begins. Once. @throws RobotFault when the checks before a first motion were not well.
  virtual void Begin() {}
  /// A motion from start to end; time goes on behind it. @throws as the drives' runs.
  [[nodiscard]] virtual loop::RunReport Run(const loop::MotionRun& run) = 0;
  /// Time ends; no record is put after it returns. May be called again.
  virtual backend::RobotTimings End() { return {}; }

  /// Since Begin().
  [[nodiscard]] virtual Time Now() const = 0;

  /// Lets time pass without a motion, and reads what states come.
  /// @param done  asked often; its argument is the state that was read since it was asked last, or
  ///              null.
  /// @returns false when `limit` came first. @throws RobotFault when the connection is gone, or no
  /// state comes for 1 s.
  [[nodiscard]] bool PassUntil(Time limit, const std::function<bool(const RobotState*)>& done);

 private:
  /// Lets time pass until something may have come, not beyond the limit.
  virtual void Pass(Time limit) = 0;
  /// A state was read while no motion runs.
  virtual void Observe(const RobotState& /*state*/) {}
  /// For how long this side has been without a state, on whatever clock tells.
  [[nodiscard]] virtual Time TimeoutNow() const { return Now(); }

  RobotState state_;
};

/// @param sink  as scenario::Run's. @throws as `connect`.
[[nodiscard]] std::unique_ptr<DriveSetting> MakeDriveSetting(const scenario::Scenario& scenario,
                                                             const backend::Factory& connect,
                                                             const robot::RobotConfig& robot,
                                                             rt::RecordSink* sink,
                                                             const RealtimeSettings& settings);

}  // namespace twin::run
