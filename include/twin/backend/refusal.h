#pragma once

#include "twin/backend/backend.h"
#include "twin/core/hand_command.h"
#include "twin/core/modes.h"
#include "twin/core/request_status.h"
#include "twin/core/setting.h"

// Translates a robot's answers to requests into the errors of the seams. The text is the same for a
// robot in this process and for one at the other end of a wire.
//
// Threads: any. Not for real-time code.
namespace twin::backend {

/// @returns how a motion with the last answer `status` ended; kNone for kMotionStarted.
[[nodiscard]] MotionEnd EndOf(MoveStatus status) noexcept;

/// Return if the request was granted. @param mode  the robot's mode, for the message.
/// @throws RobotFault or InputError, as Backend and Panel do, if it was refused; names the cure.
void RequireStarted(MoveStatus status, const MotionModes& modes, RobotMode mode);
void RequireSet(SetterStatus status, const Setting& setting, RobotMode mode);
void RequireRecovered(RecoveryStatus status, RobotMode mode);
void RequireOperated(bool done, PanelAction action, RobotMode mode);

/// The same for the hand. @throws InputError as Hand.
void RequireStarted(const HandStart& start, const HandCommand& command);

}  // namespace twin::backend
