#include "twin/robot/command_keeper.h"

namespace twin::robot {

CommandKeeper::CommandKeeper(const JointLimits& joints, const CartesianLimits& cartesian, int lost)
    : joints_(joints, lost), poses_(cartesian, joints, lost) {}

RobotCommand CommandKeeper::Keep(const RobotState& answered,
                                 const RobotCommand& command) const noexcept {
  RobotCommand kept = command;
  switch (answered.motion_generator_mode) {
    case MotionGeneratorMode::kIdle:
    case MotionGeneratorMode::kNone: break;
    case MotionGeneratorMode::kJointPosition:
      kept.q_c = joints_.Next(answered.q_d, answered.dq_d, answered.ddq_d, command.q_c).q_c;
      break;
    case MotionGeneratorMode::kJointVelocity:
      kept.dq_c =
          joints_.NextVelocity(answered.q_d, answered.dq_d, answered.ddq_d, command.dq_c).dq_c;
      break;
    case MotionGeneratorMode::kCartesianPosition:
      kept.O_T_EE_c = poses_.Next(answered, command.O_T_EE_c).O_T_EE_c;
      break;
    case MotionGeneratorMode::kCartesianVelocity:
      kept.O_dP_EE_c = poses_.NextTwist(answered, command.O_dP_EE_c).O_dP_EE_c;
      break;
  }
  return kept;
}

}  // namespace twin::robot
