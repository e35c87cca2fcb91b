#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "twin/backend/registry.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"

// Scenarios on a robot at the other end of a wire: a Panda, or a twin that is served.
namespace twin::run {

/// @param robot  "HOST" or "HOST:PORT", PORT in [1, 65534], 1337 by default; the hand's is the
/// next one. @param time   "auto", "wall" or "states". @throws InputError naming what is wrong.
[[nodiscard]] backend::RobotAddress ParseRemote(std::string_view robot, std::string_view time);

/// Keys of a scenario that have no effect on such a robot, a line each: those of simulation only
/// (plant, link, scene, pushes, buttons, computation times), and those that no request sets.
[[nodiscard]] std::vector<std::string> WithoutEffectThere(const scenario::Scenario& scenario);

/// The robot that is served by default: in the ready pose, without a scene.
[[nodiscard]] scenario::Scenario DefaultServed();

/// Makes the scenario's motion slower: every time of its trajectory, and of the hand's commands
/// beside it, is divided by `share`; the path stays. Of a planned motion the stretch is.
/// @param share  in [0.001, 1]. @throws InputError when it is not; as MakeTrajectory.
void SlowDown(scenario::Scenario& scenario, const scenario::RobotData& robot, double share);

/// One line of the checks before a robot's first motion.
struct CheckLine {
  std::string_view subject;  ///< one or two words
  bool ok = false;
  std::string text;  ///< the finding; when not ok, also the cure
};

/// Completes a capture. @param note  receives a line when datagrams are missing. @pre no thread
/// puts datagrams any more. @throws EnvironmentError as fci::Capture::Finish.
void FinishCapture(fci::Capture& capture, const std::function<void(std::string_view)>& note);

using TellCheck = std::function<void(const CheckLine&)>;

}  // namespace twin::run
