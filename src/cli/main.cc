#include <fcntl.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

#include "cli/exit_code.h"
#include "cli/program.h"
#include "controllers/joint_effort.h"
#include "controllers/joint_trajectory.h"
#include "plugins/fci/fci_backend.h"
#include "plugins/mujoco/mujoco_backend.h"
#include "twin/backend/registry.h"
#include "twin/control/registry.h"
#include "twin/core/error.h"

namespace {

std::string Environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string() : std::string(value);
}

/// $XDG_CACHE_HOME/panda-twin, else ~/.cache/panda-twin, else no cache.
std::filesystem::path CacheFolder() {
  const std::string base = Environment("XDG_CACHE_HOME");
  if (base.starts_with('/')) return std::filesystem::path(base) / "panda-twin";
  const std::string home = Environment("HOME");
  if (home.starts_with('/')) return std::filesystem::path(home) / ".cache" / "panda-twin";
  return {};
}

std::unique_ptr<twin::control::Controller> MakeJointTrajectory(
    const twin::control::ControllerRequest& request) {
  using twin::control::CommandInterface;
  if (request.interface == CommandInterface::kTorque) {
    throw twin::InputError(
        "controller joint_trajectory commands no torques; set motion.interface to joint_position, "
        "joint_velocity or cartesian_pose, or controller.type to joint_effort");
  }
  twin::controllers::JointTrajectoryOptions options;
  options.command_interface = request.interface;
  return std::make_unique<twin::controllers::JointTrajectoryController>(request.trajectory,
                                                                        options);
}

std::unique_ptr<twin::control::Controller> MakeJointEffort(
    const twin::control::ControllerRequest& request) {
  if (request.interface != twin::control::CommandInterface::kTorque) {
    throw twin::InputError(
        "controller joint_effort commands torques; set motion.interface to torque");
  }
  return std::make_unique<twin::controllers::JointEffortController>(request.trajectory);
}

/// A standard file that is closed must not become the log of a run: in its place stands one that
/// fails as a closed one does.
void OpenStandardFiles() {
  for (int descriptor = 0; descriptor <= 2; ++descriptor) {
    if (::fcntl(descriptor, F_GETFD) >= 0) continue;
    // The lowest free number is taken, that is, this one.
    if (::open("/dev/null", descriptor == 0 ? O_WRONLY : O_RDONLY) < 0) {
      std::_Exit(twin::cli::kEnvironment);
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  OpenStandardFiles();
  std::signal(SIGPIPE, SIG_IGN);  // `panda-twin run ... | head` completes its run

  twin::backend::Registry backends;
  twin::plugins::RegisterMujoco(backends);
  twin::plugins::RegisterFci(backends);
  twin::control::ControllerRegistry controllers;
  controllers.Add("joint_trajectory", &MakeJointTrajectory);
  controllers.Add("joint_effort", &MakeJointEffort);

  twin::cli::Host host;
  std::error_code error;
  host.executable = std::filesystem::read_symlink("/proc/self/exe", error);
  host.cache = CacheFolder();
  host.path = Environment("PATH");
  return twin::cli::RunProgram(argc, argv, host, {backends, controllers});
}
