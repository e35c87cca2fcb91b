#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "twin/core/joint_vector.h"
#include "twin/core/modes.h"
#include "twin/core/request_status.h"
#include "twin/core/robot_state.h"
#include "twin/record/cycle_record.h"
#include "twin/run/catalogue.h"
#include "twin/scenario/scenario.h"

namespace twin::run {

/// INT and plant of a scenario under given commands, cycle by cycle: what the twin does with what a
/// log says was commanded. Without workstation and link: a command given for a cycle is in time.
///
///   replay.Start(modes);                    // between two cycles, as are all requests
///   const auto& cycle = replay.Cycle(&command);  // null: the cycle has none, INT holds
///
/// With the scenario and the seed of a lockstep run, its requests, and the commands that were
/// served in its cycles, all states are that run's to the bit. Buttons (`panel`) and pushes come
/// from the scenario; commands of the hand are not replayed.
///
/// Threads: one at a time; different replays share nothing. Not for real time, though a cycle
/// allocates nothing.
class CommandReplay {
 public:
  /// @param scenario  of a robot, with or without a motion. @param q_start  where the arm rests,
  /// rad; absent: where the scenario says.
  /// @throws InputError and EnvironmentError as Run.
  CommandReplay(const scenario::Scenario& scenario, const RunFiles& files,
                const std::optional<JointVector>& q_start = {});
  ~CommandReplay();

  /// Requests of the next cycle, as robot::Robot.
  [[nodiscard]] MoveStatus Start(const MotionModes& modes) noexcept;
  void Stop() noexcept;
  [[nodiscard]] RecoveryStatus Recover() noexcept;

  /// Runs a cycle. @param command  of this cycle, whatever its message_id; null: none.
  /// @returns its record, valid until the next call.
  const record::CycleRecord& Cycle(const RobotCommand* command) noexcept;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::run
