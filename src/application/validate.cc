#include "twin/application/validate.h"

#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include "twin/application/application.h"
#include "twin/control/controller_library.h"
#include "twin/control/registry.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/core/time.h"
#include "twin/replay/recording.h"
#include "twin/run/run.h"

namespace twin::application {
namespace {

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
  std::string text =
      fmt::format("  motion  {}\n", DescribeMotion(scenario.motion, run.trajectory()));
  if (const std::string excess = run.ProfileExcess(); !excess.empty()) text += "  " + excess + '\n';
  return text;
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
                             const run::Catalogue& catalogue, const run::RunFiles& files,
                             const Partners* partners) {
  const MonotonicClock clock;
  const application::ApplicationRun run(scenario, catalogue, files, nullptr, clock, {}, partners);
  CheckCamera(scenario, file, run.connection());
  return fmt::format("  application  {}; what it does is planned as it goes\n",
                     scenario.application->type);
}

}  // namespace

std::string Validate(const scenario::Scenario& scenario, const std::filesystem::path& file,
                     const run::Catalogue& catalogue, const run::RunFiles& files,
                     LibraryCheck library, const Partners* partners) {
  const bool loads = library == LibraryCheck::kLoaded;
  const auto check_motion =
      loads || scenario.controller.library.empty() ? &CheckMotion : &CheckWithoutLibrary;
  std::string text = scenario.application
                         ? CheckApplication(scenario, file, catalogue, files, partners)
                         : check_motion(scenario, file, catalogue, files);
  run::RequireFree(scenario, files);
  if (!scenario.motion.touches.empty()) {
    text += fmt::format("  collisions  not checked: {}\n", scenario.motion.touches);
  }
  return text;
}

}  // namespace twin::application
