#pragma once

#include <string>
#include <vector>

#include "application/pick_plan.h"
#include "twin/application/application.h"
#include "twin/core/limits.h"

namespace twin::application {

/// What a run of pick and place noted of itself, from what the robot reported.
struct PickRecord {
  PickTask task;
  JointLimits limits;
  Grip grip;
  std::vector<std::string> robot_errors{};  ///< of motions that were ended by one
  double width_grasped = 0;                 ///< m
  double width_placed = 0;                  ///< before it was let go, m
  bool is_placed = false;
  Transform O_T_EE_placed = kIdentityTransform;  ///< measured, before it was let go
  Transform B_T_EE = kIdentityTransform;         ///< as planned
  Duration moved{};                              ///< planned duration of all motions
};

/// The demands of pick and place, and figures beside them.
[[nodiscard]] Evaluation EvaluatePick(const PickRecord& record, const TaskResult& task_result,
                                      const Evidence& evidence);

}  // namespace twin::application
