#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "twin/robot/answer_paced_robot.h"
#include "twin/robot/threaded_robot.h"
#include "twin/server/control_request.h"
#include "twin/server/served_robot.h"

namespace twin::server {

/// Carries out the requests of a control channel (control_channel.h), or of the process that serves
/// the robot.
///
/// Threads: any, one request at a time, while the robot's time runs.
class ControlledRobot {
 public:
  /// @param robot  must outlive this. @param may_reset  whether a request may reset the robot.
  /// @param has_own_time  false: it shares its time with other robots, so no request stops it.
  ControlledRobot(ServedRobot& robot, bool may_reset, bool has_own_time = true) noexcept
      : served_(robot), may_reset_(may_reset), has_own_time_(has_own_time) {}

  /// Carries out a request; a step and a recovery it begins, see IsBusy().
  /// @throws InputError when the robot refuses; RobotFault as robot::ThreadedRobot's requests.
  void Do(const ControlRequest& request);
  /// Whether cycles of a step are left, or a recovery has not ended while time runs.
  [[nodiscard]] bool IsBusy() const;
  /// The robot as it is: the line that answers a request that was carried out, without its end (see
  /// ControlChannel). @throws RobotFault.
  [[nodiscard]] std::string StatusLine() const;

 private:
  [[nodiscard]] robot::AnswerPacedRobot& Lockstep(std::string_view what) const;
  void Reset(const std::optional<JointVector>& q);
  void Place(const ControlRequest& request);
  void Operate(PanelAction action);

  ServedRobot& served_;
  const bool may_reset_;
  const bool has_own_time_;
};

}  // namespace twin::server
