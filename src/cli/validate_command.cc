#include <algorithm>

#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/picture.h"
#include "cli/say.h"
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

}  // namespace

// Prepares all that a run prepares, so that what validate passes run does not refuse.
ExitCode ValidateCommand(const ValidateFlags& flags, const Host& host,
                         const scenario::Catalogue& catalogue) {
  const scenario::Scenario scenario = scenario::Load(flags.scenario);
  const auto data =
      scenario::FindDataDirectory({host.executable, flags.data.models, flags.data.meshes});
  const scenario::Run run(scenario, catalogue, {data.models, data.mesh_package, host.cache, false},
                          nullptr);
  if (scenario.render.enabled && run.connection().truth != nullptr) {
    CheckPicture(run, scenario.render);
  }
  const auto& peaks = run.trajectory().peaks();
  Say(stdout, fmt::format("{}: ok\n", flags.scenario.string()));
  Say(stdout,
      fmt::format(
          "  motion  {} waypoints, {:.3f} s; of the limits: velocity {:.1f} %, acceleration "
          "{:.1f} %, jerk {:.2f} %\n",
          scenario.motion.waypoints.size(), ToSeconds(run.trajectory().duration()),
          Largest(peaks.velocity), Largest(peaks.acceleration), Largest(peaks.jerk)));
  FinishOutput();
  return kOk;
}

}  // namespace twin::cli
