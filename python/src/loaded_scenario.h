#pragma once

#include <filesystem>
#include <string>

#include "twin/scenario/scenario.h"

namespace twin::python {

/// A checked scenario beside the text that it was read from: replaced keys go into the text, so
/// that defaults which depend on them (of `tick` on `motion.interface`) are chosen anew.
struct LoadedScenario {
  std::string text;
  std::filesystem::path file;  ///< its name in messages; waypoints and scene are sought beside it
  scenario::Scenario scenario;
};

}  // namespace twin::python
