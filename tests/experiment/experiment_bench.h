#pragma once

#include <array>
#include <fstream>
#include <memory>
#include <string>
#include <utility>

#include "controllers/joint_trajectory.h"
#include "plugins/backends.h"
#include "support/temporary_folder.h"
#include "twin/experiment/experiment.h"
#include "twin/experiment/page.h"

namespace twin::experiment::test {

/// What experiments need to run in a test: the program's simulated backend and its controllers,
/// and the experiments' scenarios.
class ExperimentBench {
 public:
  ExperimentBench() {
    plugins::RegisterMujoco(backends_);
    controllers_.Add("joint_trajectory", [](const control::ControllerRequest& request) {
      controllers::JointTrajectoryOptions options;
      options.command_interface = request.interface;
      return std::make_unique<controllers::JointTrajectoryController>(request.trajectory, options);
    });
  }

  /// Of the scenarios as they are. @param seeds  few, for speed.
  [[nodiscard]] Config config(int seeds = 2) const {
    return {.catalogue = catalogue_,
            .files = {models_, {}, {}, false},
            .scenarios = models_ / "experiments",
            .scratch = folder_.path(),
            .seed = 1,
            .seeds = seeds,
            .progress = {}};
  }

  /// Of the calibrated loops with a motion of one second.
  [[nodiscard]] Config short_config(int seeds = 2) const {
    for (const std::string name : {"bare", "synchronous", "asynchronous"}) {
      std::string text = twin::test::ReadText(models_ / "experiments" / (name + ".yaml"));
      const std::string motion = "../scenarios/trajectories/canonical.yaml";
      text.replace(text.find(motion), motion.size(), kShortMotion);
      std::ofstream(folder_ / (name + ".yaml")) << text;
    }
    Config config = this->config(seeds);
    config.scenarios = folder_.path();
    return config;
  }

 private:
  static constexpr const char* kShortMotion =
      "{unit: rad, duration: 1 s, waypoints: [{q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}, "
      "{q: [0.05, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}]}";

  const std::filesystem::path models_ = std::filesystem::path(TWIN_SOURCE_DIR) / "models";
  const twin::test::TemporaryFolder folder_;
  backend::Registry backends_;
  control::ControllerRegistry controllers_;
  const run::Catalogue catalogue_{backends_, controllers_};
};

/// Draws what an experiment found. @returns how many of its figures the page has.
inline std::size_t FiguresOnPage(Findings findings, const std::string& id) {
  findings.id = findings.page = id;
  const std::string html = Page(std::array{std::move(findings)}, {});
  std::size_t count = 0;
  for (std::size_t at = html.find("</svg>"); at != std::string::npos;
       at = html.find("</svg>", at + 1)) {
    ++count;
  }
  return count;
}

}  // namespace twin::experiment::test
