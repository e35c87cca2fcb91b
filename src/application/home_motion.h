#pragma once

#include "twin/application/page_operator.h"
#include "twin/run/run.h"
#include "twin/run/session.h"
#include "twin/scenario/scenario.h"

namespace twin::application {

/// Moves an arm at rest to robot.q_start, at a tenth of its speed limits, on a way that the planner
/// finds free of collision with the arm itself, the scene and the free bodies where they are.
///
/// @param session  after Begin(). @param led  of the session. @param served  of the robot: what
/// surrounds the arm.
/// @throws RobotFault if the hand holds something (the planner does not know its shape), no way is
/// found, or the motion ends early; the text says which and what to do. As Session's functions.
void MoveHome(run::Session& session, const scenario::Scenario& led,
              const scenario::Scenario& served, const run::RunFiles& files,
              const PageOperator::Arrange& arrange);

}  // namespace twin::application
