#include <algorithm>

#include <fmt/format.h>

#include "cli/commands.h"
#include "twin/core/time.h"
#include "twin/scenario/data_directory.h"
#include "twin/scenario/scenario.h"

namespace twin::cli {
namespace {

/// Largest share over the joints, in percent.
double Largest(const JointVector& shares) {
  return 100 * *std::ranges::max_element(shares);
}

}  // namespace

ExitCode ValidateCommand(const ValidateFlags& flags, const Host& host,
                         const scenario::Catalogue& catalogue) {
  const scenario::Scenario run = scenario::Load(flags.scenario);
  const auto data =
      scenario::FindDataDirectory({host.executable, flags.data.models, flags.data.meshes});
  const scenario::RunFiles files{data.models, data.mesh_package, host.cache, false};
  scenario::Check(run, catalogue, files);
  const auto robot = scenario::LoadRobotData(files.models, run.robot.model, run.robot.hand);
  const auto trajectory = scenario::MakeTrajectory(run, robot);
  const auto& peaks = trajectory.peaks();
  fmt::print("{}: ok\n", flags.scenario.string());
  fmt::print(
      "  motion  {} waypoints, {:.3f} s; of the limits: velocity {:.1f} %, acceleration "
      "{:.1f} %, jerk {:.2f} %\n",
      run.motion.waypoints.size(), ToSeconds(trajectory.duration()), Largest(peaks.velocity),
      Largest(peaks.acceleration), Largest(peaks.jerk));
  return kOk;
}

}  // namespace twin::cli
