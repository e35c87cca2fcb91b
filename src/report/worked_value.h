#pragma once

#include <string>
#include <vector>

#include "report/run_end.h"

namespace twin::report {

/// Works out once more, from the numbers in the log, the value that broke a limit: one line per
/// step. For the errors of joint and Cartesian motion generators, but those behind the inverse
/// kinematics, and of commanded torques. Where the result is not the one the controller found
/// (its filters were on, the command is not in the log), nothing is claimed: the lines are then
/// empty, or say what the command asked for beside the motion.
///
/// @pre end.aborted() and end.last().violated.
[[nodiscard]] std::vector<std::string> WorkOut(const RunEnd& end);

}  // namespace twin::report
