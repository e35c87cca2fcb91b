#pragma once

#include <string>
#include <vector>

#include "report/run_end.h"

namespace twin::report {

/// Recomputes the value that violated a limit from the numbers in the log, one line per step. For
/// errors of joint and Cartesian motion generators, except those of the inverse kinematics, and of
/// commanded torques. If the result differs from the controller's (its filters were on, or the log
/// lacks the command), the lines are empty. If such a command ends the motion, they say that the
/// stop after it violates the limit.
///
/// @pre end.aborted() and end.last().violated.
[[nodiscard]] std::vector<std::string> WorkOut(const RunEnd& end);

}  // namespace twin::report
