#include <fcntl.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "cli/command.h"
#include "controllers/registration.h"
#include "plugins/backends.h"
#include "plugins/devices/registration.h"
#include "twin/backend/registry.h"
#include "twin/control/registry.h"
#include "twin/teleop/device_registry.h"

namespace {

std::string Environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

/// The program's folder in a base folder of the XDG specification: $VARIABLE/panda-twin, else
/// ~/USUAL/panda-twin, else none.
std::filesystem::path OwnFolder(const char* variable, const char* usual) {
  const std::string base = Environment(variable);
  if (base.starts_with('/')) return std::filesystem::path(base) / "panda-twin";
  const std::string home = Environment("HOME");
  if (home.starts_with('/')) return std::filesystem::path(home) / usual / "panda-twin";
  return {};
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
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow (ulimit -f) is an error that is told

  twin::backend::Registry backends;
  twin::plugins::RegisterMujoco(backends);
  twin::plugins::RegisterFci(backends);
  twin::control::ControllerRegistry controllers;
  twin::controllers::RegisterControllers(controllers);
  twin::teleop::DeviceRegistry devices;
  const auto log_flags = std::make_shared<twin::cli::LogFlags>();
  const twin::cli::Log log = twin::cli::MakeLog(*log_flags);
  twin::devices::RegisterDevices(devices, [log](std::string_view text) { log->info(text); });

  std::error_code error;
  twin::cli::Program program{
      .host = {.executable = std::filesystem::read_symlink("/proc/self/exe", error),
               .meshes = Environment("PANDA_TWIN_MESHES"),
               .cache = OwnFolder("XDG_CACHE_HOME", ".cache"),
               .state = OwnFolder("XDG_STATE_HOME", ".local/state"),
               .path = Environment("PATH"),
               .python = Environment("PANDA_TWIN_PYTHON")},
      .catalogue = {backends, controllers, &devices},
      .log_flags = log_flags,
      .log = log};
  return twin::cli::RunProgram(argc, argv, program);
}
