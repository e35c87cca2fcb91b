#pragma once

#include <memory>

#include "twin/application/application.h"
#include "twin/control/parameters.h"

namespace twin::application {

/// The paper's first application: from where the arm stands to goals drawn at random, free of
/// collision, on ways around everything that stands there, followed by joint torques.
///
/// Parameters:
///   goals       how many, one after the other; in [1, 100], 1 unless said
///   clearance   kept from everything, m, in [1 mm, 100 mm], 15 mm unless said
///   budget      collision checks a plan may take, in [1, 10^9], 100 000 unless said
///   controller  of joint_trajectory_effort
///
/// Steps: plan and execute, for each goal. Demanded: no contact, in an independent check of every
/// millisecond of the plan and, where somebody simulates the robot, in the run; the measured arm
/// within the controller's path tolerance of the plan.
[[nodiscard]] std::unique_ptr<Application> MakePlanAndExecute(control::ParameterReader& parameters);

}  // namespace twin::application
