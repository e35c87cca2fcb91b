#include "twin/report/plots.h"

#include <array>
#include <string>
#include <system_error>

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
  const std::array<std::string, kPlotFiles.size()> scripts{
      PositionScript(run, limits), TrackingScript(run), VelocityScript(run, limits),
      JerkScript(run, limits), ServedScript(run)};
  std::vector<std::filesystem::path> paths;
  for (std::size_t i = 0; i < scripts.size(); ++i) {
    paths.push_back(folder / kPlotFiles[i]);
    DrawSvg(scripts[i], paths.back());
  }
  return paths;
}

}  // namespace twin::report
