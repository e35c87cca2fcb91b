#include "twin/scenario/scenario.h"

#include <fstream>
#include <iterator>
#include <string>

#include <nanobind/operators.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>

#include "bindings.h"
#include "loaded_scenario.h"
#include "twin/application/validate.h"
#include "twin/scenario/data_directory.h"
#include "twin/scenario/text_changes.h"

namespace twin::python {
namespace {

LoadedScenario Parsed(std::string text, std::filesystem::path file) {
  scenario::Scenario scenario = scenario::ParseServed(text, file);
  return {std::move(text), std::move(file), std::move(scenario)};
}

LoadedScenario Loaded(const std::filesystem::path& named) {
  const scenario::DataDirectory data =
      scenario::FindDataDirectory({TheHost().executable, TheHost().models, TheHost().meshes});
  std::filesystem::path file = scenario::FindScenario(named, data.models);
  scenario::Scenario scenario = scenario::Load(file);  // says what is wrong with a file
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  return {std::move(text), std::move(file), std::move(scenario)};
}

LoadedScenario Replaced(const LoadedScenario& loaded, const std::string& changes) {
  constexpr std::string_view kReplaced = " (replaced)";
  std::string name = loaded.file.filename();
  if (!name.ends_with(kReplaced)) name += kReplaced;
  return Parsed(scenario::WithChanges(loaded.text, loaded.file, changes),
                loaded.file.parent_path() / name);
}

std::string Validate(const LoadedScenario& loaded, bool load) {
  using application::LibraryCheck;
  return application::Validate(loaded.scenario, loaded.file, TheCatalogue(), Files(),
                               load ? LibraryCheck::kLoaded : LibraryCheck::kNotLoaded);
}

}  // namespace

void AddScenario(nb::module_& module) {
  const nb::call_guard<GilReleased> released;
  nb::class_<LoadedScenario>(module, "LoadedScenario", "A checked scenario; see Scenario.")
      .def_static("load", &Loaded, nb::arg("named"), released)
      .def_static("parse", &Parsed, nb::arg("text"), nb::arg("file"), released)
      .def("replaced", &Replaced, nb::arg("changes"), released)
      .def("to_yaml", [](const LoadedScenario& self) { return scenario::ToYaml(self.scenario); })
      .def("to_json",
           [](const LoadedScenario& self) {
             return scenario::ToJson(scenario::ToYaml(self.scenario), self.file);
           })
      .def("validate", &Validate, nb::arg("load"), released)
      .def(
          "equals",
          [](const LoadedScenario& self, const LoadedScenario& other) {
            return self.scenario == other.scenario;
          },
          nb::arg("other"))
      .def_prop_ro("moves",
                   [](const LoadedScenario& self) {
                     const scenario::Scenario& s = self.scenario;
                     const auto& points = s.motion.waypoints;
                     return s.application || points.size() != 2 || points[0].q != points[1].q;
                   })
      .def_ro("text", &LoadedScenario::text)
      .def_ro("file", &LoadedScenario::file)
      .def_prop_ro("name", [](const LoadedScenario& self) { return self.scenario.name; })
      .def_prop_ro("description",
                   [](const LoadedScenario& self) { return self.scenario.description; })
      .def_prop_ro("seed", [](const LoadedScenario& self) { return self.scenario.seed; })
      .def_prop_ro("drive", [](const LoadedScenario& self) {
        return std::string(self.scenario.drive_name());
      });
  module.def("schema", &scenario::JsonSchema);
}

}  // namespace twin::python
