#include "twin/report/plots.h"

#include <system_error>
#include <utility>

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
  const std::pair<const char*, std::string> plots[] = {
      {"joints.svg", PositionScript(run, limits)},
      {"velocities.svg", VelocityScript(run, limits)},
      {"jerk.svg", JerkScript(run, limits)},
      {"served.svg", ServedScript(run)},
  };
  std::vector<std::filesystem::path> paths;
  for (const auto& [name, script] : plots) {
    paths.push_back(folder / name);
    DrawSvg(script, paths.back());
  }
  return paths;
}

}  // namespace twin::report
