#include "twin/report/plots.h"

#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "report/gnuplot.h"
#include "report/joint_plots.h"
#include "report/run_data.h"
#include "twin/core/error.h"

namespace twin::report {

std::vector<std::filesystem::path> WritePlots(const std::filesystem::path& log,
                                              const JointLimits& limits,
                                              const std::filesystem::path& folder) {
  limits.Validate();
  const RunData run = ReadRun(log);
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    throw EnvironmentError(fmt::format("cannot create folder {}: {}; choose another one",
                                       folder.string(), error.message()));
  }
  using Plot = std::pair<const char*, std::string>;
  std::vector<Plot> plots{
      {"joints.svg", PositionScript(run, limits)},
      {"tracking.svg", TrackingScript(run)},
      {"velocities.svg", VelocityScript(run, limits)},
      // Under torques the robot's reference stands still, or copies the target: no jerk of its own.
      run.by_torque ? Plot{"torques.svg", TorqueScript(run, limits)}
                    : Plot{"jerk.svg", JerkScript(run, limits)},
      {"served.svg", ServedScript(run)}};
  if (run.filter.commands > 0) plots.emplace_back("viability.svg", ViabilityScript(run));
  std::vector<std::filesystem::path> paths;
  for (const auto& [name, script] : plots) {
    paths.push_back(folder / name);
    DrawSvg(script, paths.back());
  }
  return paths;
}

}  // namespace twin::report
