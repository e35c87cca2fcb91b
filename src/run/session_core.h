#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "run/cycle_summary.h"
#include "run/drive_setting.h"
#include "run/prepared_motion.h"
#include "run/resolve.h"
#include "twin/run/run.h"
#include "twin/run/session.h"

namespace twin::run {

/// What sessions and runs have in common: the robot on its drive, and motions one after the other.
///
/// Threads: one thread.
class SessionCore {
 public:
  /// Connects. @param scenario  has been planned: MakePlan or MakeRobotPlan. @throws as the
  /// backend's factory.
  SessionCore(const scenario::Scenario& scenario, RobotPlan robot, const Catalogue& catalogue,
              rt::RecordSink* sink, const RealtimeSettings& settings);

  [[nodiscard]] const scenario::Scenario& scenario() const noexcept { return scenario_; }
  [[nodiscard]] const scenario::RobotData& robot() const noexcept { return robot_.robot; }
  [[nodiscard]] DriveSetting& setting() const noexcept { return *setting_; }
  [[nodiscard]] const backend::Connection& connection() const noexcept {
    return setting_->connection();
  }
  /// @throws InputError when there is no hand.
  [[nodiscard]] backend::Hand& RequireHand() const;
  /// @throws InputError when the arm stands on no mobile base.
  [[nodiscard]] backend::MobileBase& RequireBase() const;

  /// As Session's.
  void Begin(const RunHooks& hooks);
  /// @param attend  as loop::MotionRun's; may be empty.
  [[nodiscard]] MotionResult Move(PreparedMotion& motion, std::function<Time(Time)> attend);
  SessionResult End();

  [[nodiscard]] bool interrupted() const noexcept {
    return hooks_.interrupted != nullptr && *hooks_.interrupted;
  }
  void Tell(std::string_view kind, std::string_view text) const {
    if (hooks_.event) hooks_.event(setting_->Now(), kind, text);
  }
  /// Until a state came. @throws RobotFault as DriveSetting::PassUntil.
  [[nodiscard]] RobotState NextState();

 private:
  [[nodiscard]] std::uint64_t SeedOf(std::uint64_t motion) const noexcept;

  const scenario::Scenario scenario_;
  const RobotPlan robot_;
  RunHooks hooks_;
  std::uint64_t motions_ = 0;  ///< begun
  std::vector<FollowedMotion> followed_;
  CycleSummary summary_;
  std::unique_ptr<DriveSetting> setting_;
};

}  // namespace twin::run
