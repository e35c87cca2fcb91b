#pragma once

#include <string>
#include <vector>

#include "application/scripted_operator.h"
#include "twin/application/application.h"
#include "twin/teleop/teleoperator.h"
#include "twin/teleop/teleoperator_config.h"

namespace twin::application {

/// What a session of teleoperation noted of itself.
struct TeleoperationRecord {
  FetchTask task;
  teleop::TeleoperatorConfig config;
  std::vector<teleop::TeleoperatorStatus> trace{};  ///< every 50 ms
  std::vector<std::string> robot_errors{};
  int switches = 0;  ///< of the mode
  int motions = 0;   ///< of a scripted person
};

/// The demands of teleoperation, and figures beside them.
[[nodiscard]] Evaluation EvaluateTeleoperation(const TeleoperationRecord& record,
                                               const Evidence& evidence);

}  // namespace twin::application
