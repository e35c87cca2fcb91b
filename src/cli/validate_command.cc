#include <algorithm>
#include <filesystem>
#include <string>

#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/picture.h"
#include "cli/say.h"
#include "twin/application/application_run.h"
#include "twin/core/clock.h"
#include "twin/core/time.h"
#include "twin/scenario/assembly.h"
#include "twin/scenario/data_directory.h"
#include "twin/scenario/scenario.h"

namespace twin::cli {
namespace {

/// Largest share over the joints, in percent.
double Largest(const JointVector& shares) {
  return 100 * *std::ranges::max_element(shares);
}

std::string DescribeMotion(const scenario::MotionSection& motion,
                           const reference::Trajectory& trajectory) {
  const double length_s = ToSeconds(trajectory.duration());
  if (!motion.poses.empty()) {
    return fmt::format("{} poses, {:.3f} s, within the Cartesian limits", motion.poses.size() + 1,
                       length_s);
  }
  const reference::PeakShares& peaks = trajectory.peaks();
  const std::string points =
      motion.plan ? "planned" : fmt::format("{} waypoints", motion.waypoints.size());
  return fmt::format(
      "{}, {:.3f} s; of the limits: velocity {:.1f} %, acceleration {:.1f} %, jerk {:.2f} %",
      points, length_s, Largest(peaks.velocity), Largest(peaks.acceleration), Largest(peaks.jerk));
}

void CheckCamera(const scenario::Scenario& scenario, const std::filesystem::path& file,
                 const backend::Connection& connection) {
  if (scenario.render.enabled && connection.truth != nullptr) {
    CheckPicture(connection, scenario.render, file);
  }
}

std::string CheckMotion(const scenario::Scenario& scenario, const std::filesystem::path& file,
                        const scenario::Catalogue& catalogue, const scenario::RunFiles& files) {
  const scenario::Run run(scenario, catalogue, files, nullptr);
  CheckCamera(scenario, file, run.connection());
  return fmt::format("  motion  {}\n", DescribeMotion(scenario.motion, run.trajectory()));
}

std::string CheckApplication(const scenario::Scenario& scenario, const std::filesystem::path& file,
                             const scenario::Catalogue& catalogue,
                             const scenario::RunFiles& files) {
  const MonotonicClock clock;
  const application::ApplicationRun run(scenario, catalogue, files, nullptr, clock);
  CheckCamera(scenario, file, run.connection());
  return fmt::format("  application  {}; what it does is planned as it goes\n",
                     scenario.application->type);
}

}  // namespace

// Prepares all that a run prepares, so that what validate passes run does not refuse.
ExitCode ValidateCommand(const ValidateFlags& flags, const Host& host,
                         const scenario::Catalogue& catalogue) {
  const scenario::Scenario scenario = scenario::Load(flags.scenario);
  const auto data =
      scenario::FindDataDirectory({host.executable, flags.data.models, flags.data.meshes});
  const scenario::RunFiles files{data.models, data.mesh_package, host.cache, false};
  const std::string text = scenario.application
                               ? CheckApplication(scenario, flags.scenario, catalogue, files)
                               : CheckMotion(scenario, flags.scenario, catalogue, files);
  Say(stdout, fmt::format("{}: ok\n{}", flags.scenario.string(), text));
  FinishOutput();
  return kOk;
}

}  // namespace twin::cli
