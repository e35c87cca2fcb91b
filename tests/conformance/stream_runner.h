#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "conformance/reference_rules.h"
#include "conformance/stream_plan.h"
#include "contract/backend_harness.h"
#include "twin/core/robot_errors.h"

namespace twin::test {

/// What came of a stream.
struct StreamResult {
  Finding finding;  ///< the first rule that was broken
  bool started = false;
  bool aborted = false;
  RobotErrors errors;  ///< that ended the motion
  std::uint64_t cycles = 0;
};

/// Runs a stream against a robot on the ideal plant. @param checked  with a checker watching, which
/// must see every cycle.
[[nodiscard]] StreamResult RunStream(const StreamPlan& plan, const HarnessCase& harness,
                                     bool checked = true);

/// Takes away from a stream that fails what is not needed for it.
[[nodiscard]] StreamPlan Shrink(StreamPlan plan,
                                const std::function<bool(const StreamPlan&)>& fails);

}  // namespace twin::test
