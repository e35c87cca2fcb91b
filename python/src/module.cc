#include <filesystem>
#include <string>

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>

#include "bindings.h"
#include "controllers/registration.h"
#include "plugins/backends.h"
#include "plugins/devices/registration.h"
#include "twin/backend/registry.h"
#include "twin/control/registry.h"
#include "twin/plant/model_cache.h"
#include "twin/scenario/data_directory.h"
#include "twin/teleop/device_registry.h"

namespace twin::python {
namespace {

Host host;

/// All of it lives as long as the module.
struct Registries {
  backend::Registry backends;
  control::ControllerRegistry controllers;
  teleop::DeviceRegistry devices;
  run::Catalogue catalogue{backends, controllers, &devices};

  Registries() {
    plugins::RegisterMujoco(backends);
    plugins::RegisterFci(backends);
    controllers::RegisterControllers(controllers);
    devices::RegisterDevices(devices, [](std::string_view /*text*/) {});
  }
};

}  // namespace

const Host& TheHost() {
  return host;
}

const run::Catalogue& TheCatalogue() {
  static const Registries registries;
  return registries.catalogue;
}

run::RunFiles Files() {
  const scenario::DataDirectory data =
      scenario::FindDataDirectory({host.executable, host.models, host.meshes});
  const bool is_cache_usable = !host.cache.empty() && plant::RepairModelCache(host.cache, {});
  return {data.models, data.mesh_package, is_cache_usable ? host.cache : std::filesystem::path(),
          false};
}

}  // namespace twin::python

NB_MODULE(_core, module) {
  namespace python = twin::python;
  module.def("version", [] { return std::string(TWIN_VERSION); });
  module.def(
      "set_host",
      [](std::filesystem::path executable, std::filesystem::path models,
         std::filesystem::path meshes, std::filesystem::path cache, std::filesystem::path state,
         std::string path) {
        python::host = {std::move(executable), std::move(models), std::move(meshes),
                        std::move(cache),      std::move(state),  std::move(path)};
      },
      nanobind::kw_only(), nanobind::arg("executable"), nanobind::arg("models"),
      nanobind::arg("meshes"), nanobind::arg("cache"), nanobind::arg("state"),
      nanobind::arg("path"));
  python::AwaitCallsAtExit();
  python::AddEnvs(module);
  python::AddErrors(module);
  python::AddModel(module);
  python::AddServed(module);
  python::AddScenario(module);
  python::AddReplay(module);
  python::AddRun(module);
  python::AddCommands(module);
  python::AddState(module);
  python::AddSession(module);
  python::AddCell(module);
  python::AddLog(module);
  python::AddLogPictures(module);
}
