#pragma once

#include "twin/backend/backend.h"
#include "twin/core/hand_command.h"
#include "twin/core/modes.h"
#include "twin/core/panel.h"
#include "twin/core/request_status.h"
#include "twin/core/setting.h"

// What a robot answers to requests, as the seams tell it: the same words whichever robot answered,
// one in process or one at the other end of a wire.
//
// Threads: any. Not for real-time code.
namespace twin::backend {

/// How a motion whose last answer was `status` ended; kMotionStarted: it has not.
[[nodiscard]] MotionEnd EndOf(MoveStatus status) noexcept;

/// Return when the request was granted. @param mode  the robot's, for the text.
/// @throws RobotFault, InputError as Backend and Panel when it was refused, with the cure.
void RequireStarted(MoveStatus status, const MotionModes& modes, RobotMode mode);
void RequireSet(SetterStatus status, const Setting& setting, RobotMode mode);
void RequireRecovered(RecoveryStatus status, RobotMode mode);
void RequireOperated(bool done, PanelAction action, RobotMode mode);

/// The same of the hand. @throws InputError as Hand.
void RequireStarted(const HandStart& start, const HandCommand& command);

}  // namespace twin::backend
