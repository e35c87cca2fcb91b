#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>

#include <fmt/format.h>

#include "cli/commands/commands.h"
#include "cli/shared_flags.h"
#include "twin/application/application.h"
#include "twin/control/controller_library.h"
#include "twin/control/registry.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/core/time.h"
#include "twin/replay/recording.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

namespace twin::cli {
namespace {

struct ValidateFlags {
  std::filesystem::path scenario;
  bool load = false;      ///< also code of controller.library
  std::string may_touch;  ///< instead of motion.touches
  DataFlags data;
};

constexpr const char* kNotLoaded = "not_loaded";

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
    replay::CheckPicture(connection, scenario.render, file);
  }
}

std::string CheckMotion(const scenario::Scenario& scenario, const std::filesystem::path& file,
                        const run::Catalogue& catalogue, const run::RunFiles& files) {
  const run::Run run(scenario, catalogue, files, nullptr);
  CheckCamera(scenario, file, run.connection());
  return fmt::format("  motion  {}\n", DescribeMotion(scenario.motion, run.trajectory()));
}

/// Stands for a controller whose library is not loaded.
class NotLoaded final : public control::Controller {
 public:
  explicit NotLoaded(control::CommandInterface interface) : interface_(interface) {}
  [[nodiscard]] control::CommandInterface command_interface() const noexcept override {
    return interface_;
  }
  void Activate(const RobotState& /*state*/, Time /*now*/) override {}
  void Update(const RobotState& /*state*/, Time /*now*/,
              control::ControllerOutput& /*output*/) noexcept override {}
  void Deactivate() noexcept override {}

 private:
  control::CommandInterface interface_;
};

/// The same motion by a controller that understands no parameters and is never run.
/// @throws InputError naming file and line when there is no such library.
scenario::Scenario WithoutLibrary(scenario::Scenario scenario) {
  try {
    control::RequireLibrary(scenario.controller.library);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", scenario.places.library.where, error.what()));
  }
  scenario.controller.library.clear();
  scenario.controller.type = kNotLoaded;
  scenario.controller.parameters.clear();
  return scenario;
}

std::string CheckWithoutLibrary(const scenario::Scenario& scenario,
                                const std::filesystem::path& file, const run::Catalogue& catalogue,
                                const run::RunFiles& files) {
  control::ControllerRegistry known;
  known.Add(kNotLoaded, [](const control::ControllerRequest& request) {
    return std::make_unique<NotLoaded>(request.interface);
  });
  return CheckMotion(WithoutLibrary(scenario), file, {catalogue.backends, known, catalogue.devices},
                     files) +
         fmt::format("  controller  {} is there, not loaded; validate --load runs its code too\n",
                     scenario.controller.library.string());
}

std::string CheckApplication(const scenario::Scenario& scenario, const std::filesystem::path& file,
                             const run::Catalogue& catalogue, const run::RunFiles& files) {
  const MonotonicClock clock;
  const application::ApplicationRun run(scenario, catalogue, files, nullptr, clock);
  CheckCamera(scenario, file, run.connection());
  return fmt::format("  application  {}; what it does is planned as it goes\n",
                     scenario.application->type);
}

// Prepares all that a run prepares, so that what validate passes run does not refuse; but runs no
// code that a scenario names unless asked.
int Validate(const ValidateFlags& flags, const Program& program) {
  scenario::Scenario scenario = LoadScenario(flags.scenario, flags.data, program.host);
  const run::RunFiles files = FilesOf(flags.data, program);
  if (!flags.may_touch.empty()) scenario.motion.touches = flags.may_touch;
  const auto check = scenario.application                                ? &CheckApplication
                     : flags.load || scenario.controller.library.empty() ? &CheckMotion
                                                                         : &CheckWithoutLibrary;
  std::string text = check(scenario, flags.scenario, program.catalogue, files);
  run::RequireFree(scenario, files);
  if (!scenario.motion.touches.empty()) {
    text += fmt::format("  collisions  not checked: {}\n", scenario.motion.touches);
  }
  Say(stdout, fmt::format("{}: ok\n{}", flags.scenario.string(), text));
  FinishOutput();
  return kOk;
}

}  // namespace

void AddValidate(CLI::App& app, Program& program) {
  const auto [validate, flags] =
      AddCommand(app, program, "validate", "Check a scenario without running it", &Validate);
  Add(validate, "scenario FILE", flags.scenario, "Scenario file")->required();
  validate.add_flag("--load", flags.load,
                    "Load the scenario's controller.library too, which runs code of it");
  AddMayTouch(validate, flags.may_touch);
  AddData(validate, flags.data);
}

}  // namespace twin::cli
