#pragma once

#include <bitset>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "conformance/measured_oracle.h"
#include "conformance/mode_rules.h"
#include "conformance/reference_rules.h"
#include "conformance/step_oracle.h"
#include "twin/backend/backend.h"
#include "twin/core/robot_state.h"
#include "twin/core/setting.h"

namespace twin::test {

/// What the checker is told of the robot it watches.
struct CheckedRobot {
  OracleLimits limits;
  /// Of motions that it makes by itself, braking among them; nullopt: as of commands.
  std::optional<JointLimits> own_limits{};
  MeasuredLimits measured;
  setting::Filters filters;
  setting::CollisionBehavior collision_behavior;
  /// The arm is where the reference is, and nothing touches it.
  bool is_ideal = true;

  [[nodiscard]] const JointLimits& brakes_by() const {
    return own_limits ? *own_limits : limits.joints;
  }
};

/// Watches a robot from the workstation: every request, every command, every state. Recomputes from
/// those alone what the next state must be, and what a motion must be aborted for. Every cycle must
/// be seen: the link loses nothing and delays nothing beyond its cycle. Of an arm that is not ideal
/// torque motions are not checked, where INT takes over from what it measures, nor what comes after
/// it closed the brakes on an arm that does not come to rest.
///
/// Threads: one.
class StateChecker {
 public:
  /// Tells how the last motion ended; asked only when one has.
  using Describe = std::function<backend::Description()>;

  StateChecker(const CheckedRobot& robot, Describe describe);

  /// A request was made, after the last state. @param accepted  what came of it.
  void OnStart(const MotionModes& modes, bool accepted);
  void OnRequest(Ask ask, bool accepted);
  void OnSetting(const Setting& setting, bool accepted);

  /// A command was written after the last state.
  void OnCommand(const RobotCommand& command);

  /// The next state.
  void OnState(const RobotState& state);

  /// The first rule that was broken: "cycle 123: ...".
  [[nodiscard]] const Finding& finding() const { return finding_; }

 private:
  enum class Phase : std::uint8_t {
    kNone,        ///< no motion
    kRequested,   ///< granted, not in a state yet
    kStarting,    ///< before the first command
    kRunning,     ///< commands are taken or lost
    kFinishing,   ///< the finished command was taken
    kPreempting,  ///< StopMove
  };

  // state_checker.cc
  void Note(const Finding& finding);
  void CheckRequest(Ask ask, bool accepted);
  void CheckIdle(const RobotState& s);
  void CheckExternal(const RobotState& s);
  void CheckMode(const RobotState& s);
  void CheckWithoutMotion(const RobotState& s);
  void CheckComingToRest(const RobotState& s);
  void CheckErrors(const RobotState& s);
  void Become(RobotMode mode);

  // motion_rules.cc
  void CheckMotion(const RobotState& s);
  void BeginCycle();
  [[nodiscard]] Verdict JudgeCycle(const RobotState& s, bool in_detail) const;
  [[nodiscard]] Verdict JudgePreempted(const RobotState& s) const;
  [[nodiscard]] Verdict JudgeMotionMeasured(bool in_detail) const;
  [[nodiscard]] Verdict JudgeStep(bool in_detail) const;
  [[nodiscard]] Verdict JudgeCartesianStep(bool in_detail) const;
  [[nodiscard]] Verdict JudgeJointStep() const;
  [[nodiscard]] JointMotion Completed() const;
  void CheckAbort(const RobotState& s);
  void CheckDetails(const RobotState& s, const Verdict& verdict);
  void CheckCycle(const RobotState& s);
  void CheckTaken(const RobotState& s);
  void CheckTakenTorque(const RobotState& s);
  void CheckHeld(const RobotState& s);
  void CheckCompletion(const RobotState& s);
  [[nodiscard]] bool IsLagging() const;
  void CheckEnd(const RobotState& s);
  void CheckSuccessRate(const RobotState& s);
  void Count(bool served);
  [[nodiscard]] bool IsCartesian() const;

  CheckedRobot robot_;
  Describe describe_;
  Finding finding_;

  bool has_last_ = false;
  bool has_halted_ = false;  ///< and this ends the checks
  RobotState last_;
  std::optional<RobotCommand> command_;  ///< the newest that answers the last state

  Situation situation_;  ///< as it stands after all requests
  int recovering_ = 0;   ///< states that showed recovery
  int braking_ = 0;      ///< cycles of coming to rest so far
  int longest_braking_ = 0;
  bool load_was_set_ = false;  ///< INT may know of one that is not there
  RobotErrors reason_;         ///< what reflex_reason must show

  Phase phase_ = Phase::kNone;
  MotionModes modes_;
  bool user_stopped_ = false;  ///< the motion was ended by the user stop, not told yet
  bool has_elbow_ = false;     ///< of the last command taken
  bool is_regular_ = false;    ///< the arm is away from singularities, as of some cycles ago
  bool external_acts_ = false;
  bool took_over_ = false;  ///< the external torque was switched off in this cycle
  int waited_ = 0;
  int lost_in_row_ = 0;
  std::bitset<100> window_;
  std::size_t counted_ = 0;
  JointMotion joint_step_;          ///< of this cycle, when a joint motion runs
  CartesianMotion cartesian_step_;  ///< when a Cartesian one does
};

}  // namespace twin::test
