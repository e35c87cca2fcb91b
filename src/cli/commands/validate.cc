#include <filesystem>
#include <string>

#include <fmt/format.h>

#include "cli/commands/commands.h"
#include "cli/shared_flags.h"
#include "twin/application/record_cell.h"
#include "twin/application/validate.h"
#include "twin/core/error.h"
#include "twin/scenario/cell.h"
#include "twin/scenario/scenario.h"

namespace twin::cli {
namespace {

struct ValidateFlags {
  std::filesystem::path scenario;
  bool load = false;      ///< also code of controller.library
  std::string may_touch;  ///< instead of motion.touches
  DataFlags data;
};

std::string CheckCell(const std::filesystem::path& file, const ValidateFlags& flags,
                      const Program& program) {
  RefuseIf(flags.load || !flags.may_touch.empty(),
           "this scenario has several robots: --load and --no-collision-check are of one");
  return application::ValidateCell(scenario::LoadCell(file), flags.scenario, program.catalogue,
                                   FilesOf(flags.data, program));
}

std::string Check(const ValidateFlags& flags, const Program& program) {
  const std::filesystem::path file = ScenarioFile(flags.scenario, flags.data, program.host);
  if (scenario::HasRobots(file)) return CheckCell(file, flags, program);
  scenario::Scenario scenario = LoadScenario(flags.scenario, flags.data, program.host);
  if (!flags.may_touch.empty()) scenario.motion.touches = flags.may_touch;
  using application::LibraryCheck;
  return application::Validate(scenario, flags.scenario, program.catalogue,
                               FilesOf(flags.data, program),
                               flags.load ? LibraryCheck::kLoaded : LibraryCheck::kNotLoaded);
}

int Validate(const ValidateFlags& flags, const Program& program) {
  const std::string text = Check(flags, program);
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
