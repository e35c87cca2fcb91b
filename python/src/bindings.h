#pragma once

#include <filesystem>
#include <string>

#include <nanobind/nanobind.h>

#include "gil.h"
#include "twin/run/catalogue.h"

// The parts of the extension module panda_twin._core, and what they share. Every call that
// simulates, renders, plans or waits releases the GIL; no thread of C++ ever takes it.
namespace twin::python {

namespace nb = nanobind;

/// What the host tells the module: panda_twin/_host.py reads it from the environment.
struct Host {
  std::filesystem::path executable;  ///< beside which the models are sought (scenario::DataSearch)
  std::filesystem::path models;      ///< given by the user; empty: sought
  std::filesystem::path meshes;      ///< given by the user; empty: sought
  std::filesystem::path cache;       ///< folder of compiled models; empty: none
  std::filesystem::path state;       ///< folder of the user's records of runs; empty: none
  std::string path;                  ///< the search path of programs
};

[[nodiscard]] const Host& TheHost();

/// The backends, controllers and devices that the program has, too.
[[nodiscard]] const run::Catalogue& TheCatalogue();

/// Models, meshes and cache as the host has them. @throws as scenario::FindDataDirectory.
[[nodiscard]] run::RunFiles Files();

// One per source of the same name.
void AddEnvs(nb::module_& module);
void AddErrors(nb::module_& module);
void AddModel(nb::module_& module);
void AddServed(nb::module_& module);
void AddReplay(nb::module_& module);
void AddRun(nb::module_& module);
void AddScenario(nb::module_& module);
void AddCell(nb::module_& module);
void AddCommands(nb::module_& module);
void AddSession(nb::module_& module);
void AddState(nb::module_& module);
void AddLog(nb::module_& module);
void AddLogPictures(nb::module_& module);

}  // namespace twin::python
